// SPDX-License-Identifier: MIT
// Confidence intervals of all parameters of a fit: Wald's and those of the profile likelihood.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::fit {

struct FittedModel;

enum class IntervalMethod {
  kWald,     ///< estimate and standard error, on a scale where the likelihood is nearly parabolic
  kProfile,  ///< where the likelihood, maximized over all else, falls by what chance allows
};
/// \throws UsageError if there is no such method
IntervalMethod parse_interval_method(std::string_view text);
std::string interval_method_text(IntervalMethod method);

/// What a parameter is.
enum class ParameterKind { kFixed, kDeviation, kCorrelation, kVariance, kSigma };

/// The interval of one parameter. A limit that is not known is NaN, one that does not exist
/// infinite; the note says why.
struct ParameterInterval {
  ParameterKind kind = ParameterKind::kFixed;
  std::string name{};  ///< "a", "b:C", "sd(a)", "cor(a, b)", "sd(a | stand)", "delta", "sigma"
  double estimate = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  std::string note{};  ///< empty, or what there is to say of the limits
};

struct Intervals {
  IntervalMethod method = IntervalMethod::kWald;
  double level = 0.95;
  std::string likelihood{};  ///< which one it is, in words
  std::vector<ParameterInterval> parameters{};
};

struct IntervalOptions {
  IntervalMethod method = IntervalMethod::kWald;
  double level = 0.95;   ///< of confidence, between 0 and 1
  unsigned threads = 1;  ///< over parameters; 0 as many as there are cores
};

/// Intervals of coefficients, standard deviations and correlations of random effects, parameters of
/// the variance function and sigma.
///
/// Wald: coefficients by t with the fit's standard errors and degrees of freedom, the others from
/// the observed information on the scales of R nlme's intervals(). Profile: the values c at which
/// twice the fall of the log-likelihood, maximized with the parameter held at c, is the quantile of
/// chi-squared with one degree of freedom; for ols that of the squared t, as R's confint() of nls.
/// Where an estimate is at its boundary (a standard deviation of 0, a correlation of 1),
/// the interval has one limit only, and the reference is the half-and-half mixture of chi-squared
/// with 0 and 1 degrees of freedom. docs/inference.md says which likelihood a method has.
/// \param table  the rows that the fit was made of
/// \throws UsageError if the fit did not converge, the table is another one, or the level is not
///   between 0 and 1
/// Parameters are worked on in parallel; the result does not depend on the number of threads.
/// Source: Pinheiro and Bates 2000, sections 2.4.3 and 7.5.2; Venzon and Moolgavkar 1988, Applied
/// Statistics 37, 87-94; Self and Liang 1987, J. Am. Stat. Assoc. 82, 605-610.
Intervals confidence_intervals(const FittedModel& fit,
                               const data::Table& table,
                               const IntervalOptions& options = {});

}  // namespace silvafit::fit
