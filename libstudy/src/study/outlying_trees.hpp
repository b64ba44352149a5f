// SPDX-License-Identifier: MIT
// Trees whose residuals are far beyond those of the others.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace silvafit::study {

/// The outliers among the residuals of a model.
struct OutlyingTrees {
  std::vector<Eigen::Index> observations{};  ///< the farthest first
  std::vector<double> distances{};  ///< of each, in robust standard deviations of all residuals
  /// Their part of the sum of the squared standardized residuals.
  double share = 0.0;
};

/// The trees more than 8 robust standard deviations from zero. The scale is the median absolute
/// residual divided by 0.6745, which equals the standard deviation of a normal distribution and
/// which up to half of the residuals cannot inflate. Of normal residuals none in 1e14 is so far
/// away, of t-distributed ones with 5 degrees of freedom one in 3,000.
/// Source of the scale: Hampel 1974, J. Am. Stat. Assoc. 69, 383-393 (median deviation).
/// \param standardized  (N) residuals divided by their standard deviation
OutlyingTrees outlying_trees(const Eigen::VectorXd& standardized);

}  // namespace silvafit::study
