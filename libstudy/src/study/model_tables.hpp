// SPDX-License-Identifier: MIT
// The chosen models in the tables of a paper: coefficients, variance components and accuracy,
// plots.
#pragma once

#include "silvafit/study/study.hpp"
#include "study/formatted_table.hpp"

namespace silvafit::study {

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
