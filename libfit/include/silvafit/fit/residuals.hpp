// SPDX-License-Identifier: MIT
// Residuals of a fit, at the levels of prediction and on several scales for plots and tests.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Residuals of one level of prediction.
struct LevelResiduals {
  Eigen::VectorXd fitted{};        ///< (N)
  Eigen::VectorXd raw{};           ///< (N) y - fitted
  Eigen::VectorXd standardized{};  ///< (N) raw / (sigma g), "Pearson" in R nlme
};

/// Residuals of N observations in the order of the table's rows.
struct Residuals {
  std::vector<std::size_t> rows{};   ///< (N) of the table
  std::vector<std::string> group{};  ///< (N) `stand/plot` where nested, empty without groups
  Eigen::VectorXd observed{};        ///< (N)
  LevelResiduals population{};       ///< of f(beta)
  LevelResiduals conditional{};      ///< of f(beta + b), the same without random effects
  /// (N) standardized residuals of the conditional level made independent by the Cholesky factor of
  /// the residuals' correlation (nlme's "normalized"); the standardized ones if they are
  /// independent given b.
  Eigen::VectorXd normalized{};
  /// (N) residuals of the model linear around the estimates, including the random effects,
  /// L^-1 (y - f(beta + b) + Z b) with L L' = Z Psi Z' + sigma^2 G R G of a group, rows in the
  /// order of its observations: independent and standard normal if the model holds.
  Eigen::VectorXd marginal{};  ///< NaN with crossed groups or more than two levels
};

/// The residuals of the complete rows of a table.
///
/// g is evaluated at the conditional fitted values at both levels, as in nlme. Groups that are not
/// in the fit have b = 0.
/// \throws as NonlinearModel for the table
/// Source: Pinheiro and Bates 2000, sections 4.3 and 5.3.
Residuals residuals(const FittedModel& fit, const data::Table& table);

/// Covariance of the responses of the complete rows of a table, in its order.
///
/// Given the random effects sigma^2 G R G; `is_marginal`: Z Psi Z' + sigma^2 G R G of the model
/// linear around the estimates, where the responses of different groups are independent.
/// \return (N x N), so that a table has the rows of one group, or of a few
/// \throws UsageError with crossed groups; as NonlinearModel for the table
Eigen::MatrixXd response_covariance(const FittedModel& fit,
                                    const data::Table& table,
                                    bool is_marginal);

}  // namespace silvafit::fit
