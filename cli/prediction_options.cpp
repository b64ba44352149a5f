// SPDX-License-Identifier: MIT
#include "prediction_options.hpp"

#include "help.hpp"
#include "setting_options.hpp"
#include "silvafit/study/analysis_setting_list.hpp"

namespace silvafit::cli {

void add_digits_option(CLI::App& command, int& digits) {
  constexpr int kAllDigits = 17;  // distinguish any two doubles
  command
      .add_option(
          "--digits", digits, "Significant digits of predictions; 17 writes all that there are")
      ->check(CLI::Range(1, kAllDigits))
      ->type_name("N")
      ->capture_default_str()
      ->group(kOutputSection);
}

void add_prediction_options(CLI::App& command, study::PredictionSettings& settings) {
  each_setting(settings, SettingOptions(command, "Predictions"));
}

void refuse_idle_prediction_options(const CLI::App& command,
                                    const study::PredictionSettings& settings) {
  const bool is_calibrated = settings.level == "calibrated";
  refuse_idle(command,
              "--interval-kind",
              settings.interval > 0.0 || settings.standard_errors,
              "--interval or --standard-errors");
  refuse_idle(command,
              "--new-groups",
              is_calibrated || settings.level == "conditional",
              "--level conditional or calibrated");
  refuse_idle(command, "--seen-groups", is_calibrated, "--level calibrated");
}

}  // namespace silvafit::cli
