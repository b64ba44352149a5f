// SPDX-License-Identifier: MIT
// Confidence intervals of all parameters of a fit: Wald's and those of the profile likelihood.
#pragma once

#include <stop_token>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/parameter_intervals.hpp"

namespace silvafit::fit {

struct FittedModel;

struct IntervalOptions {
  IntervalMethod method = IntervalMethod::kWald;
  double level = 0.95;   ///< of confidence, between 0 and 1
  unsigned threads = 1;  ///< over parameters; 0: all cores
  /// Ends the search for the limits of profiles by the exception Stopped, if given.
  std::stop_token stop{};
};

/// Intervals of coefficients, standard deviations and correlations of random effects, parameters of
/// the variance function and sigma.
///
/// Wald: coefficients by t with the fit's standard errors and degrees of freedom, the others from
/// the observed information on the scales of R nlme's intervals(). Profile: the values c at which
/// twice the decrease of the log-likelihood, maximized with the parameter held at c, is the
/// quantile of chi-squared with one degree of freedom; for ols that of the squared t, as R's
/// confint() of nls. Where an estimate is at its boundary (a standard deviation of 0, a correlation
/// of 1), the interval has only one limit, and the reference is the half-and-half mixture of
/// chi-squared with 0 and 1 degrees of freedom. docs/inference.md lists the likelihoods of the
/// methods. Parameters are processed in parallel; the result does not depend on the number of
/// threads.
/// \param table  the rows of the fit
/// \throws UsageError if the fit did not converge, the table is another one, or the level is not
///   between 0 and 1
/// Source: Pinheiro and Bates 2000, sections 2.4.3 and 7.5.2; Venzon and Moolgavkar 1988, Applied
/// Statistics 37, 87-94; Self and Liang 1987, J. Am. Stat. Assoc. 82, 605-610.
Intervals confidence_intervals(const FittedModel& fit,
                               const data::Table& table,
                               const IntervalOptions& options = {});

}  // namespace silvafit::fit
