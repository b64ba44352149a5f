// SPDX-License-Identifier: MIT
// Lists of names in the command line, such as plots.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"

namespace silvafit::cli {

/// The names of `1,2,"B, north"`: commas within double quotes are part of a name, as in CSV, and
/// two quotes there are one.
std::vector<std::string> split_names(std::string_view text);

/// Adds a repeatable option for names that are separated by commas.
CLI::Option* add_names_option(CLI::App& command,
                              const std::string& name,
                              std::vector<std::string>& names,
                              const std::string& description);

}  // namespace silvafit::cli
