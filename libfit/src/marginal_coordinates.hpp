// SPDX-License-Identifier: MIT
// The parameters of a marginal likelihood as one vector of numbers of order one.
#pragma once

#include <Eigen/Core>

#include "marginal_likelihood.hpp"
#include "relative_factor.hpp"

namespace silvafit::fit {

/// x = (beta, factor of the coarser grouping, factor of the finer one, variance parameters, log
/// sigma), with each coefficient in a unit that moves the mean by about one residual standard
/// deviation.
class MarginalCoordinates {
 public:
  /// \param unit   (p) of each coefficient
  MarginalCoordinates(const NonlinearModel& model,
                      const MarginalLikelihood& likelihood,
                      Eigen::Index variance_parameters,
                      Eigen::VectorXd unit);

  Eigen::Index size() const {
    return beta_ + outer_.parameter_count() + inner_.parameter_count() + variance_ + 1;
  }
  MarginalPoint point(const Eigen::VectorXd& x) const;
  Eigen::VectorXd gradient(const MarginalValue& value) const;
  /// \param outer, inner  covariances Psi in the coefficients' own units
  Eigen::VectorXd coordinates(const ObservationPoint& observation,
                              const Eigen::MatrixXd& outer,
                              const Eigen::MatrixXd& inner) const;
  const Eigen::VectorXd& unit() const { return unit_; }
  Eigen::Index beta_count() const { return beta_; }
  /// Where the parameters of the factors are in x.
  Eigen::Index factor_begin() const { return beta_; }
  Eigen::Index factor_count() const { return outer_.parameter_count() + inner_.parameter_count(); }
  /// x with the covariance of a grouping in scaled units made larger in one direction.
  Eigen::VectorXd widened(const Eigen::VectorXd& x,
                          bool is_outer,
                          const Eigen::VectorXd& direction,
                          double size) const;
  /// The scaled covariance of a grouping.
  Eigen::MatrixXd scaled_covariance(const Eigen::VectorXd& x, bool is_outer) const;

 private:
  Eigen::VectorXd outer_parameters(const Eigen::VectorXd& x) const {
    return x.segment(beta_, outer_.parameter_count());
  }
  Eigen::VectorXd inner_parameters(const Eigen::VectorXd& x) const {
    return x.segment(beta_ + outer_.parameter_count(), inner_.parameter_count());
  }

  Eigen::VectorXd unit_;
  Eigen::VectorXd outer_unit_;
  Eigen::VectorXd inner_unit_;
  Eigen::Index beta_ = 0;
  Eigen::Index variance_ = 0;
  RelativeFactor outer_;
  RelativeFactor inner_;
};

}  // namespace silvafit::fit
