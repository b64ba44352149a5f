// SPDX-License-Identifier: MIT
// The coefficients for the predictions of the rows of a table, and their uncertainty.
#pragma once

#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {

/// M sets of p coefficients: of the groups of each term, of the population. The uncertainty of a
/// set has two parts: the error of the estimates, and the random effects that were not estimated,
/// which are open.
struct CoefficientSets {
  MatrixXd coefficients{};                 ///< (p x M)
  MatrixXd covariances{};                  ///< (p p x M) of the error of estimates, by columns
  std::vector<std::vector<bool>> known{};  ///< (M) whether the effects of each term are estimated
  std::vector<bool> is_marginal{};  ///< (M) whether the value is the mean over the open effects

  std::vector<Index> set_of_row{};        ///< (N)
  std::vector<unsigned> unknown_terms{};  ///< (N) as Prediction has them
  std::vector<bool> is_missing{};         ///< (N) rows without a value
  std::vector<Index> calibrated_from{};   ///< (N), empty unless calibrated
};

/// \param with_covariances  whether to compute covariances
/// \throws as predict()
CoefficientSets coefficient_sets(const FittedModel& fit,
                                 const data::Table& table,
                                 Level level,
                                 const PredictionOptions& options,
                                 bool with_covariances);

/// (p x p) the covariance of a term's random effects among all coefficients.
/// \param names, covariance  of the term
MatrixXd among_coefficients(const FittedModel& fit,
                            const std::vector<std::string>& names,
                            const MatrixXd& covariance);
/// (p x p) covariance of the effects of the terms that are not known.
MatrixXd open_covariance(const FittedModel& fit, const std::vector<bool>& known);

}  // namespace silvafit::fit
