// SPDX-License-Identifier: MIT
#include "study_arguments.hpp"

#include <string_view>
#include <utility>

#include "setting_options.hpp"

namespace silvafit::cli {
namespace {

/// One criterion for all levels; likelihood-ratio tests are then not used.
void apply_criterion(const std::string& text, study::StudyOptions& options) {
  if (text == "level") return;
  const study::Criterion all = study::parse_criterion(text);
  options.criteria = {.base = all, .covariates = all, .random = all, .variance = all};
  options.needs_tests = false;
}

/// The settings of the file, except those given on the command line.
void apply_configuration(const CLI::App& command, StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  const auto has_priority = [&command](std::string_view key) {
    // A window of the command line replaces a circle of the file, and vice versa.
    if (key == "window" || key == "circle") {
      return is_given(command, "window") || is_given(command, "circle");
    }
    return is_given(command, key);
  };
  arguments.settings = study::read_study_configuration(
      arguments.configuration,
      &catalogue,
      {.settings = std::move(arguments.settings), .is_given = has_priority});
}

}  // namespace

void apply_settings(const CLI::App& command, StudyArguments& arguments) {
  if (!arguments.configuration.empty()) apply_configuration(command, arguments);
  apply_criterion(arguments.criterion, arguments.settings.study);
}

}  // namespace silvafit::cli
