// SPDX-License-Identifier: MIT
// What `silvafit study` is asked to do: options of the command line, and settings of a file.
#pragma once

#include <filesystem>
#include <string>

#include "command.hpp"
#include "inventory_options.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::cli {

struct StudyArguments {
  InventoryArguments inventory{};
  UnitArguments units{};
  study::StudyOptions study{};
  std::string out{};
  std::string criterion = "level";
  std::string configuration{};
  std::string initial{};  ///< file that a configuration to start from is written to
  CommonOptions common{};
};

/// Takes what --config and --criterion say; options of the command line come before the file.
void apply_settings(const CLI::App& command, StudyArguments& arguments);

/// All settings that the study has, as a file in a folder would say them.
/// \param folder  that a window is told relative to; empty: the current one
study::StudyConfiguration settings_of(const StudyArguments& arguments,
                                      const std::filesystem::path& folder);

}  // namespace silvafit::cli
