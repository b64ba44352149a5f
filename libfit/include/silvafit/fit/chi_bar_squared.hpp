// SPDX-License-Identifier: MIT
// Mixtures of chi-squared distributions: the reference of tests of variances that may be zero.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace silvafit::fit {

/// A mixture of chi-squared distributions: weights[i] is the probability of i degrees of freedom
/// above `base`. The reference of a likelihood ratio if parameters are at a bound under the
/// hypothesis, such as variances at zero.
struct ChiBarSquared {
  int base = 0;
  std::vector<double> weights{1.0};  ///< their sum is one

  /// P(mixture >= x); a component without degrees of freedom is a point mass at 0.
  double upper_tail(double x) const;
  /// "chi-squared with 2 degrees of freedom", "1/2 chi-squared(1) + 1/2 chi-squared(2)".
  std::string text() const;
};

/// Of k variances that are tested together, whose estimates are independent: binomial weights.
ChiBarSquared independent_variances(int k);

/// Of k variances whose unconstrained estimates have a covariance (up to a factor): the probability
/// that i of them are positive after projection on the quadrant in the metric of its inverse. In
/// closed form for k <= 2, else simulated.
/// \param covariance  (k x k) positive definite
/// \param draws       of the simulation
/// \throws UsageError if the matrix is not square and positive definite, or k > 12
/// Source: Silvapulle and Sen 2005, Constrained Statistical Inference, chapter 3.
ChiBarSquared correlated_variances(const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                                   std::uint64_t seed = 1,
                                   int draws = 100000);

}  // namespace silvafit::fit
