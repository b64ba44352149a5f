// SPDX-License-Identifier: MIT
// Settings of analyses from lists of R.
#pragma once

#include <filesystem>

#include "conversion.hpp"
#include "setting_arguments.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/study_configuration.hpp"
#include "silvafit/study/tree_equations.hpp"

namespace silvafit::r {

/// How a model is fitted, by the arguments of silvafit().
fit::FitModelOptions fit_options(const Arguments& options);

/// The settings of a list, from the arguments of their keys.
template <typename Settings>
Settings settings_of(const Arguments& arguments, Settings settings = {}) {
  each_setting(settings, SettingArguments(arguments));
  return settings;
}

inline study::ReadingSettings reading_settings(const Arguments& arguments) {
  return settings_of<study::ReadingSettings>(arguments);
}

/// Windows are a file, or rings of coordinates from an object of sf.
study::UnitSettings unit_settings(const Arguments& arguments);

/// The table of plots is a file, or columns of a data frame.
study::SamplingSettings sampling_settings(const Arguments& arguments);

/// All settings of a study. Those that the argument `given` names have priority over the file of
/// the argument `config`, if there is one.
study::StudyConfiguration study_settings(const Arguments& arguments,
                                         const study::Catalogue& catalogue);

/// Equations of volume, biomass and carbon.
study::EquationSettings equation_settings(const Arguments& arguments);

/// Whether the argument `progress` asks for a progress bar.
bool shows_progress(const Arguments& arguments);

/// The folder of the catalogue and the pages, from the R functions.
std::filesystem::path data_folder(const Arguments& arguments);

}  // namespace silvafit::r
