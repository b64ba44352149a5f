// SPDX-License-Identifier: MIT
// All lists of settings by their names, for what describes them: help, signatures, pages.
#pragma once

#include "silvafit/fit/setting_list.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow_setting_list.hpp"

namespace silvafit::study {

/// Calls visit(name, settings) for each list, with default values.
template <typename Visit>
void each_setting_list(Visit&& visit) {
  const StudyConfiguration study;
  visit("study", study.study);
  visit("reading", study.reading);
  visit("rows", study.reading.rows);
  visit("units", study.units);
  visit("sampling", study.sampling);
  visit("stand", StandOptions());
  visit("equations", EquationSettings());
  visit("model", fit::ModelTexts());
  visit("fit", fit::FitModelOptions());
  visit("intervals", fit::IntervalOptions());
  visit("bootstrap", fit::BootstrapOptions());
  visit("cross-validation", fit::CrossValidationOptions());
  visit("predictions", PredictionSettings());
  visit("imputation", ImputeOptions());
  visit("grow", GrowSettings());
  visit("view", ViewOptions());
}

}  // namespace silvafit::study
