// SPDX-License-Identifier: MIT
// The settings of `silvafit study`: options of the command line, and those of a file.
#pragma once

#include <string>

#include "command.hpp"
#include "inventory_options.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::cli {

struct StudyArguments {
  std::string inventory{};
  study::StudyConfiguration settings{};
  std::string out{};
  std::string workbook{};  ///< file for all tables, or for the trees as a layer
  std::string criterion = "level";
  std::string configuration{};
  std::string initial{};  ///< file that a configuration to start from is written to
  TableArguments table{};
  CommonOptions common{};
};

/// Takes what --config and --criterion say; options of the command line come before the file.
void apply_settings(const CLI::App& command, StudyArguments& arguments);

}  // namespace silvafit::cli
