// SPDX-License-Identifier: MIT
// Variance functions in the parameters that an optimiser likes, and back in those that people read.
#pragma once

#include <Eigen/Core>

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The residual scale g(v) of each observation and its derivatives.
struct ResidualScale {
  Eigen::ArrayXd weight{};           ///< (N) g^-2
  Eigen::ArrayXXd log_derivative{};  ///< (N x m) d log g / d internal parameter
  double sum_log = 0.0;              ///< sum of log g
};

/// A variance function with internal parameters that are of order one and nearly uncorrelated with
/// sigma: v is taken relative to its typical value, so that g is about 1 whatever delta is, and
/// constant-plus-power is (sin^2 phi + cos^2 phi |v/v0|^delta), which holds both a constant
/// variance and a pure power as ordinary points.
class VarianceModel {
 public:
  /// \param typical_values  (N) positive magnitudes like those v will have: |response| or the
  /// column
  VarianceModel(const VarianceFunction& function, const Eigen::VectorXd& typical_values);

  Eigen::Index parameter_count() const { return function_.parameter_count(); }
  /// Internal parameters to start from.
  Eigen::VectorXd start() const;
  /// Internal parameters of a constant variance.
  Eigen::VectorXd constant() const;

  /// \param v           (N) fitted values or the column
  /// \param parameters  (m) internal
  ResidualScale scale(const Eigen::VectorXd& v,
                      const Eigen::VectorXd& parameters,
                      bool with_derivatives) const;

  /// Number of observations whose |v| is so small that it had to be floored.
  Eigen::Index floored(const Eigen::VectorXd& v) const;

  VarianceEstimate estimate(const Eigen::VectorXd& parameters) const;
  /// The factor from the internal residual scale to nlme's sigma.
  double sigma_factor(const Eigen::VectorXd& parameters) const;

 private:
  Eigen::ArrayXd log_relative(const Eigen::VectorXd& v) const;

  VarianceFunction function_;
  double typical_ = 1.0;  ///< geometric mean for powers, arithmetic mean for exponentials
};

}  // namespace silvafit::fit
