// SPDX-License-Identifier: MIT
// Where the parameters of a likelihood are in one vector of numbers of order one.
#pragma once

#include <Eigen/Core>

#include "model/relative_factor.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Where the parameters are in a vector x of numbers of order one:
/// x = (beta / unit, factor of the coarser grouping, factor of the finer one, internal variance
/// parameters, log of the internal sigma). A factor is L of Psi = L L' with effects in units.
class SurfaceLayout {
 public:
  /// \param unit        (p) of each coefficient
  /// \param beta_count  p, or 0 where the likelihood is that of contrasts free of beta
  SurfaceLayout(const NonlinearModel& model,
                const VarianceModel& variance,
                Eigen::VectorXd unit,
                Eigen::Index beta_count);

  Eigen::Index size() const { return sigma_at() + 1; }
  Eigen::Index beta_count() const { return beta_; }
  Eigen::Index outer_at() const { return beta_; }
  Eigen::Index inner_at() const { return beta_ + outer_.parameter_count(); }
  Eigen::Index variance_at() const { return inner_at() + inner_.parameter_count(); }
  Eigen::Index variance_count() const { return variance_; }
  Eigen::Index sigma_at() const { return variance_at() + variance_; }

  const Eigen::VectorXd& unit() const { return unit_; }
  const RelativeFactor& factor(bool is_outer) const { return is_outer ? outer_ : inner_; }
  /// (q) units of the effects of a grouping.
  const Eigen::VectorXd& effect_unit(bool is_outer) const {
    return is_outer ? outer_unit_ : inner_unit_;
  }
  Eigen::Index factor_at(bool is_outer) const { return is_outer ? outer_at() : inner_at(); }
  /// The parameters of a grouping's factor.
  Eigen::VectorXd factor_part(const Eigen::VectorXd& x, bool is_outer) const {
    return x.segment(factor_at(is_outer), factor(is_outer).parameter_count());
  }
  Eigen::VectorXd variance_part(const Eigen::VectorXd& x) const {
    return x.segment(variance_at(), variance_);
  }
  /// Parameters as a vector.
  /// \param outer, inner  covariances Psi in the coefficients' own units
  /// \param log_sigma     of the internal sigma
  Eigen::VectorXd coordinates(const Eigen::VectorXd& beta,
                              const Eigen::MatrixXd& outer,
                              const Eigen::MatrixXd& inner,
                              const Eigen::VectorXd& variance,
                              double log_sigma) const;

 private:
  Eigen::VectorXd unit_;
  Eigen::VectorXd outer_unit_;
  Eigen::VectorXd inner_unit_;
  Eigen::Index beta_ = 0;
  Eigen::Index variance_ = 0;
  RelativeFactor outer_;
  RelativeFactor inner_;
};

}  // namespace silvafit::fit
