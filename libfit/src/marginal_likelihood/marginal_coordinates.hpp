// SPDX-License-Identifier: MIT
// The parameters of a marginal likelihood as one vector of numbers of order one.
#pragma once

#include <Eigen/Core>

#include "inference/surface_layout.hpp"
#include "marginal_likelihood/marginal_likelihood.hpp"

namespace silvafit::fit {

/// What is between points of the likelihood and vectors x, laid out as SurfaceLayout says, with
/// each coefficient in a unit that moves the mean by about one residual standard deviation.
class MarginalCoordinates {
 public:
  /// \param unit  (p) of each coefficient
  MarginalCoordinates(const NonlinearModel& model,
                      const VarianceModel& variance,
                      const Eigen::VectorXd& unit)
      : layout_(model, variance, unit, unit.size()) {}

  const SurfaceLayout& layout() const { return layout_; }
  MarginalPoint point(const Eigen::VectorXd& x) const;
  Eigen::VectorXd gradient(const MarginalValue& value) const;
  /// \param outer, inner  covariances Psi in the coefficients' own units
  Eigen::VectorXd coordinates(const ObservationPoint& observation,
                              const Eigen::MatrixXd& outer,
                              const Eigen::MatrixXd& inner) const;
  /// x with the covariance of a grouping in scaled units made larger in one direction.
  Eigen::VectorXd widened(const Eigen::VectorXd& x,
                          bool is_outer,
                          const Eigen::VectorXd& direction,
                          double size) const;
  /// The scaled covariance of a grouping.
  Eigen::MatrixXd scaled_covariance(const Eigen::VectorXd& x, bool is_outer) const;

 private:
  /// (q x q) L of a grouping in scaled units.
  Eigen::MatrixXd factor(const Eigen::VectorXd& x, bool is_outer) const {
    return layout_.factor(is_outer).factor(layout_.factor_part(x, is_outer));
  }

  SurfaceLayout layout_;
};

}  // namespace silvafit::fit
