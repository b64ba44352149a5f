// SPDX-License-Identifier: MIT
// Quantiles of t distributions for many degrees of freedom.
#pragma once

#include <vector>

namespace silvafit::fit {

/// The quantile of one probability as a function of the degrees of freedom f. A polynomial in 1/f
/// (Chebyshev) replaces the search of the quantile, which takes 20 times as long, where it agrees
/// with it to 1e-12.
class StudentQuantiles {
 public:
  /// \param probability  between 0 and 1
  explicit StudentQuantiles(double probability);
  /// \return NaN unless `freedom` is above 0
  double at(double freedom) const;

 private:
  double by_polynomial(double freedom) const;

  double probability_;
  std::vector<double> coefficients_{};  ///< empty: the polynomial is not used
};

}  // namespace silvafit::fit
