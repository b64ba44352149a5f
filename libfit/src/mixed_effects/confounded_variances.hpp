// SPDX-License-Identifier: MIT
// Variance components that are not identifiable from the data.
#pragma once

#include <string>
#include <vector>

#include "model/variance_weights.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The point at which the covariance of the observations is tested.
struct VariancePoint {
  MatrixXd coefficients{};          ///< (p x G) of each group, random effects included
  std::vector<MatrixXd> effects{};  ///< (q x q) Psi of each term
  VectorXd variance{};              ///< (m) internal parameters of the variance function
  VectorXd fitted{};                ///< (N) fitted values of these coefficients
  VectorXd residual_sd{};           ///< (N)
  bool is_restricted = false;  ///< the likelihood is that of contrasts free of the coefficients
};

struct ConfoundedVariances {
  /// In the order and with the names of confidence_intervals(): "sd(a | stand)", "cor(a, b)",
  /// "delta", "sigma".
  std::vector<std::string> names{};
  bool has_effects = false;  ///< standard deviations or correlations are among them
  int directions = 0;        ///< number of directions with constant likelihood
};

/// Variance components that are not identifiable: along some direction of them the covariance of
/// the observations does not change, and so their likelihood does not either.
///
/// With V = sum of Z Psi Z' of the terms + R, the derivatives of V by the elements of Psi, the
/// parameters of the variance function and sigma are matrices; the components are identifiable if
/// and only if these matrices are linearly independent, which their Gram matrix tr(R^-1 V_k R^-1
/// V_l) shows. This also holds for boundary (singular) fits, where the Hessian of the likelihood
/// cannot be used. A direction in which Psi would not remain a covariance is ignored, as are
/// parameters of constant-plus-power at their bounds.
/// \param variance  the variance function of the model
/// Cost: a pass over the data for the derivatives, then one over the groups; for the restricted
/// likelihood memory for N values for each component and coefficient.
/// Source: Rothenberg 1971, Econometrica 39, 577-591, for local identification by the information
/// matrix.
ConfoundedVariances confounded_variances(const NonlinearModel& model,
                                         const VarianceModel& variance,
                                         const VariancePoint& point);

}  // namespace silvafit::fit
