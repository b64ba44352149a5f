// SPDX-License-Identifier: MIT
// Uncertainty of random effects given the data.
#pragma once

#include <vector>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Conditional covariances of the random effects of each group of one grouping.
///
/// q random effects, p coefficients, G groups. With beta-hat the estimate of the coefficients and
/// b-hat(beta) the random effects for given ones, b-hat(beta) - b has the conditional covariance V
/// and is independent of beta-hat in the model linear around the estimates, so that
///
///     Var(b-hat - b) = V + S Var(beta-hat) S',   Cov(b-hat - b, beta-hat) = S Var(beta-hat),
///
/// with S = d b-hat / d beta'. This is the inverse of Henderson's joint coefficient matrix.
/// Source: Henderson 1975, Biometrics 31, 423-447; McLean, Sanders and Stroup 1991.
struct EffectUncertainty {
  Eigen::MatrixXd covariances{};    ///< (q q x G) V of each group, column by column
  Eigen::MatrixXd sensitivities{};  ///< (q p x G) S of each group, column by column

  bool is_known() const { return covariances.size() > 0; }
  Eigen::MatrixXd covariance(Eigen::Index group, Eigen::Index q) const {
    return covariances.col(group).reshaped(q, q);
  }
  Eigen::MatrixXd sensitivity(Eigen::Index group, Eigen::Index q, Eigen::Index p) const {
    return sensitivities.col(group).reshaped(q, p);
  }
};

/// What the data say about the effects of several terms together: each group has a covariance with
/// groups of the other terms. The inverse covariance of all effects given the data is that of
/// their prior plus these curvatures.
///
/// T terms, C cells: combinations of groups that have observations.
struct EffectCells {
  std::vector<std::vector<Eigen::Index>> groups{};  ///< (T x C) the group of each cell in a term
  /// (r (r + 1) / 2 x C) second derivatives of each cell's negative log density by the r
  /// coefficients that have random effects in any term, in the order of the coefficients: lower
  /// triangle by columns.
  Eigen::MatrixXd curvatures{};
};

}  // namespace silvafit::fit
