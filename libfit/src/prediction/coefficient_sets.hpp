// SPDX-License-Identifier: MIT
// The coefficients for the predictions of the rows of a table, and their uncertainty.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {

/// M sets of p coefficients: of groups, of coarser groups, of the population. The
/// uncertainty of a set has two parts: the error of the estimates, and the random effects that were
/// not estimated.
struct CoefficientSets {
  /// The random effects that are not estimated.
  enum class Open {
    kNothing,  ///< those of the group are estimated
    kInner,    ///< the coarser group's are estimated, or there is one grouping
    kAll,      ///< of both groupings
  };

  Eigen::MatrixXd coefficients{};   ///< (p x M)
  Eigen::MatrixXd covariances{};    ///< (p p x M) of the error of estimates, by columns
  std::vector<Open> open{};         ///< (M)
  std::vector<bool> is_marginal{};  ///< (M) whether the value is the mean over the open effects

  std::vector<Eigen::Index> set_of_row{};       ///< (N)
  std::vector<bool> is_new_group{};             ///< (N)
  std::vector<bool> is_missing{};               ///< (N) rows without a value
  std::vector<Eigen::Index> calibrated_from{};  ///< (N), empty unless calibrated
};

/// \param with_covariances  whether to compute covariances
/// \throws as predict()
CoefficientSets coefficient_sets(const FittedModel& fit,
                                 const data::Table& table,
                                 Level level,
                                 const PredictionOptions& options,
                                 bool with_covariances);

/// (p x p) the covariance of the fixed effects. Coefficients without one are treated as known if
/// they were held or published; those that are not identifiable remain NaN.
Eigen::MatrixXd fixed_covariance(const FittedModel& fit);

/// (p x p) the covariance of a grouping's random effects among all coefficients.
/// \param names, covariance  of the grouping
Eigen::MatrixXd among_coefficients(const FittedModel& fit,
                                   const std::vector<std::string>& names,
                                   const Eigen::MatrixXd& covariance);
/// (p x p) covariance of the effects that are not estimated.
Eigen::MatrixXd open_covariance(const FittedModel& fit, CoefficientSets::Open open);

}  // namespace silvafit::fit
