// SPDX-License-Identifier: MIT
// Likelihood-ratio tests of nested fits, with mixture references for variances at zero.
#pragma once

#include <string>

#include "silvafit/fit/chi_bar_squared.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A likelihood-ratio test of a smaller model in a larger one.
struct NestedTest {
  double statistic = 0.0;  ///< twice the gain in log-likelihood
  int degrees_of_freedom = 0;
  double p_chi_squared = 1.0;  ///< by chi-squared with these degrees of freedom
  /// By the reference of the hypothesis; the same as above if no variance is tested.
  double p = 1.0;
  ChiBarSquared reference{};
  std::string note{};  ///< a note on the reference or the fits, or empty
};

/// The test of two fits to the same observations by the same method. If the larger model fits all
/// observations exactly, the statistic is infinite and p is 0.
/// The variances of several independent effects are treated as independently estimated.
/// \throws UsageError if there is no such test: the fits did not converge, are not nested, have
///   other data or methods, or are by restricted likelihood with other fixed effects
/// Source: Self and Liang 1987, J. Am. Stat. Assoc. 82, 605-610; Stram and Lee 1994, Biometrics 50,
/// 1171-1177.
NestedTest likelihood_ratio_test(const FittedModel& larger, const FittedModel& smaller);

}  // namespace silvafit::fit
