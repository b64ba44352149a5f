// SPDX-License-Identifier: MIT
// Which variance components the data cannot tell apart.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/variance_weights.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Where the covariance of the observations is looked at.
struct VariancePoint {
  Eigen::MatrixXd coefficients{};  ///< (p x G) of each group, random effects included
  Eigen::MatrixXd outer{};         ///< (r x r) Psi of the coarser of two groupings
  Eigen::MatrixXd inner{};         ///< (q x q) Psi
  Eigen::VectorXd variance{};      ///< (m) internal parameters of the variance function
  Eigen::VectorXd fitted{};        ///< (N) fitted values of these coefficients
  Eigen::VectorXd residual_sd{};   ///< (N)
  bool is_restricted = false;      ///< the likelihood is that of contrasts free of the coefficients
};

struct ConfoundedVariances {
  /// In the order and with the names of confidence_intervals(): "sd(a | stand)", "cor(a, b)",
  /// "delta", "sigma".
  std::vector<std::string> names{};
  int directions = 0;  ///< in which they can be moved without changing the likelihood
};

/// Variance components that can take each other's place: along some direction of them the
/// covariance of the observations stays what it is, and so does their likelihood.
///
/// With V = sum of Z Psi Z' of the groupings + R, the derivatives of V by the elements of Psi, the
/// parameters of the variance function and sigma are matrices; the components are told apart if and
/// only if these do not depend linearly on each other, which is seen from their Gram matrix
/// tr(R^-1 V_k R^-1 V_l). That holds on the edge of the covariances, too, where the Hessian of the
/// likelihood says nothing. A direction that leaves no room for Psi to remain a covariance does not
/// count, nor do parameters of constant-plus-power at the ends of their ranges.
/// \param variance  the variance function of the model
/// Cost: a pass over the data for the derivatives, then one over the groups; for the restricted
/// likelihood memory for N values for each component and coefficient.
/// Source: Rothenberg 1971, Econometrica 39, 577-591, for local identification by the information
/// matrix.
ConfoundedVariances confounded_variances(const NonlinearModel& model,
                                         const VarianceModel& variance,
                                         const VariancePoint& point);

}  // namespace silvafit::fit
