// SPDX-License-Identifier: MIT
// The settings of `silvafit study` from the command line and from a file.
#pragma once

#include <string>

#include "command.hpp"
#include "inventory_options.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::cli {

struct StudyArguments {
  std::string command_line{};  ///< as the report shows it
  std::string inventory{};
  study::StudyConfiguration settings{};
  std::string out{};
  std::string workbook{};  ///< file for all tables, or for the trees as a layer
  std::string criterion = "level";
  std::string configuration{};
  std::string initial{};  ///< output file for a configuration with the default settings
  TableArguments table{};
  source::TableChoice plots{};
  CommonOptions common{};
};

/// Applies --config and --criterion; options of the command line have priority over the file.
void apply_settings(const CLI::App& command, StudyArguments& arguments);

}  // namespace silvafit::cli
