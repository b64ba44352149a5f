// SPDX-License-Identifier: MIT
// The random effects of a term as columns, and the free directions of their covariance.
#pragma once

#include <optional>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The random effects of a term, on columns of unit mean square that are orthogonal within each
/// block of effects with free covariances, so that near-dependences of the columns do not appear as
/// dependences of their products.
struct EffectColumns {
  const RandomEffects* effects = nullptr;
  MatrixXd columns{};     ///< (N x q) Z T^-1, divided by the residual standard deviations
  MatrixXd triangle{};    ///< (q x q) T
  VectorXd size{};        ///< (q) root mean squares of the columns of Z
  MatrixXd covariance{};  ///< (q x q) T Psi T'
  /// (q x d) combinations of effects of a block with free covariances that do not change the mean,
  /// in the units of `size`; the columns of one of their effects are 0.
  MatrixXd redundant{};
  Index free_covariances = 0;  ///< variances and covariances that these leave without effect
};

/// \param psi       (q x q) covariance of the effects
/// \param jacobian  (N x p) of the mean by the coefficients, divided by the residual standard
///                  deviations
EffectColumns effect_columns(const NonlinearModel& model,
                             const RandomEffects& random,
                             const MatrixXd& psi,
                             const MatrixXd& jacobian);

/// (q x q) changes of T Psi T' that the form of the covariance allows, one for each parameter.
std::vector<MatrixXd> forms_of(const EffectColumns& level);

}  // namespace silvafit::fit
