// SPDX-License-Identifier: MIT
// Mixtures of chi-squared distributions: the reference of tests of variances that may be zero.
#pragma once

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

}  // namespace silvafit::fit
