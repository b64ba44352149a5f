// SPDX-License-Identifier: MIT
// Uncertainty of random effects given the data.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Conditional covariances of the random effects of each group of one grouping.
///
/// q random effects, p coefficients, G groups; for the finer of two nested groupings, s effects of
/// the coarser one. With beta-hat the estimate of the coefficients and b-hat(beta) the random
/// effects for given ones, b-hat(beta) - b has the conditional covariance V and is independent of
/// beta-hat in the model linear around the estimates, so that
///
///     Var(b-hat - b) = V + S Var(beta-hat) S',   Cov(b-hat - b, beta-hat) = S Var(beta-hat),
///
/// with S = d b-hat / d beta'. This is the inverse of Henderson's joint coefficient matrix.
/// Source: Henderson 1975, Biometrics 31, 423-447; McLean, Sanders and Stroup 1991.
struct EffectUncertainty {
  Eigen::MatrixXd covariances{};    ///< (q q x G) V of each group, column by column
  Eigen::MatrixXd sensitivities{};  ///< (q p x G) S of each group, column by column
  /// (q s x G) covariance with the effects of the group's coarser group; empty with one grouping.
  Eigen::MatrixXd cross_covariances{};

  bool is_known() const { return covariances.size() > 0; }
  Eigen::MatrixXd covariance(Eigen::Index group, Eigen::Index q) const {
    return covariances.col(group).reshaped(q, q);
  }
  Eigen::MatrixXd sensitivity(Eigen::Index group, Eigen::Index q, Eigen::Index p) const {
    return sensitivities.col(group).reshaped(q, p);
  }
  Eigen::MatrixXd cross_covariance(Eigen::Index group, Eigen::Index q, Eigen::Index s) const {
    return cross_covariances.col(group).reshaped(q, s);
  }
};

}  // namespace silvafit::fit
