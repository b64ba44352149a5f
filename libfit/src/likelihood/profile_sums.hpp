// SPDX-License-Identifier: MIT
// The end of a profile: coefficients and sigma, once the random effects are eliminated.
#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "likelihood/linear_mixed_profile.hpp"

namespace silvafit::fit {

/// The derivative of the likelihood by a symmetric matrix of cross products, F F', with the vectors
/// of F in rows.
struct Adjoint {
  Index count = 0;
  std::vector<double> vectors{};  ///< (count x width)
};

/// Cross products of [X w] without the random effects, and half the log-determinant of A.
struct ProfileSums {
  MatrixXd total{};  ///< (width x width)
  double log_determinant = 0.0;

  /// The members of the profile that need no derivatives.
  LinearMixedProfile solve(const LinearMixedModel& model,
                           const VectorXd& displacement,
                           const HeldParameters& held);
  /// dF / d total: the residuals' part of S and, restricted, that of log|X'V^-1 X| / 2.
  Adjoint adjoint(const LinearMixedModel& model, const LinearMixedProfile& at) const;

 private:
  Eigen::LLT<MatrixXd> information_;
};

}  // namespace silvafit::fit
