// SPDX-License-Identifier: MIT
// Common parts of `silvafit grow`: its options and its output.
#pragma once

#include <string>

#include "command.hpp"
#include "silvafit/study/grow.hpp"

namespace silvafit::cli {

/// The options of the command, except the common ones.
/// \param file, options  are filled when the command line is parsed
void add_grow_options(CLI::App& command, std::string& file, study::GrowSettings& options);

/// Prints the result as text or as JSON.
void report_grown(const CommonOptions& common, const study::GrowResult& result);

}  // namespace silvafit::cli
