// SPDX-License-Identifier: MIT
// The tables of a study.
#pragma once

#include <vector>

#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/study_record.hpp"
#include "study/formatted_table.hpp"

namespace silvafit::study {

/// All tables in the order of the levels: species (importance values), candidates, covariates,
/// random_effects, variance_functions, estimates, variance_components, statistics, gains,
/// level_tests.
std::vector<FormattedTable> study_tables(const StudyRecord& record, const Catalogue& catalogue);

/// Table 1 of Wang and others 2023: density, importance values of each layer and of all trees,
/// sizes (means and standard deviations), basal area and dominant height, by falling importance.
/// Areas, and values per hectare, need windows; layers need heights.
FormattedTable species_importance_table(const StudyRecord& record);

/// Table 4 of Wang and others 2023: a row for each chosen model with its estimates, the stars of
/// their t tests, AIC, log-likelihood, and letters of the models that differ with the stars of the
/// likelihood-ratio test against the row above. A parameter without intercept has no estimate of
/// its own; effects of covariates are in the column of the covariate.
FormattedTable coefficients_table(const Study& study);

/// Table 5 of Wang and others 2023: a row for each chosen model with residual variance, variances
/// and correlations of the random effects, variance function, and accuracy; R2 and RMSE also for
/// plots left out.
FormattedTable variance_and_fit_table(const Study& study);

/// A row for each plot and random effect of the chosen mixed models: EBLUP, conditional standard
/// error, and how far the plot lies from the others (outlying_plots.hpp).
FormattedTable plot_effects_table(const Study& study);

}  // namespace silvafit::study
