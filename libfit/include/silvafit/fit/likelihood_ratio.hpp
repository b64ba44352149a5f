// SPDX-License-Identifier: MIT
// Likelihood-ratio tests of nested fits, with the right reference.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "silvafit/fit/chi_bar_squared.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A likelihood-ratio test of a smaller model in a larger one.
struct NestedTest {
  double statistic = 0.0;  ///< twice the gain in log-likelihood
  int degrees_of_freedom = 0;
  double p_chi_squared = 1.0;  ///< by chi-squared with as many degrees of freedom
  /// By the reference that fits the hypothesis; the same as above where no variance is tested.
  double p = 1.0;
  ChiBarSquared reference{};
  std::string note{};  ///< what to know of the reference and of the fits, or empty
};

/// The test of two fits to the same observations by the same method. Where the larger model goes
/// through all observations, the statistic is infinite and p is 0.
/// \param variances  covariance of the variances that are tested if there are several independent
///   effects (see covariance_of_variances); without it they count as independent
/// \throws UsageError if there is no such test: the fits did not converge, are not nested, are to
///   other data or by other methods, or by restricted likelihood with other fixed effects
/// Source: Self and Liang 1987, J. Am. Stat. Assoc. 82, 605-610; Stram and Lee 1994, Biometrics 50,
/// 1171-1177.
NestedTest likelihood_ratio_test(const FittedModel& larger,
                                 const FittedModel& smaller,
                                 const std::optional<Eigen::MatrixXd>& variances = std::nullopt);

}  // namespace silvafit::fit
