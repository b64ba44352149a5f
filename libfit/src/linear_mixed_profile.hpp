// SPDX-License-Identifier: MIT
// The likelihood of a linear mixed model with beta and sigma profiled out, and its exact gradient.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "variance_weights.hpp"

namespace silvafit::fit {

/// A linear mixed model w = X beta + Z b + e on grouped rows; the columns of Z are columns of X.
struct LinearMixedModel {
  Eigen::MatrixXd design{};                 ///< (N x p) X
  Eigen::VectorXd working{};                ///< (N) w
  std::vector<Eigen::Index> random{};       ///< (q) columns of X that are Z
  std::vector<Eigen::Index> group_begin{};  ///< (G + 1)
};

/// What is left of the data once weights are given: per group the cross products of [X w].
class GroupMoments {
 public:
  GroupMoments(const LinearMixedModel& model, const Eigen::ArrayXd& weight);

  Eigen::Index groups() const { return groups_; }
  /// (p+1 x p+1) [X w]' G^-2 [X w] of a group.
  auto group(Eigen::Index index) const { return products_.middleCols(index * width_, width_); }

 private:
  Eigen::Index groups_;
  Eigen::Index width_;
  Eigen::MatrixXd products_;
};

/// The profiled model at one covariance.
struct LinearMixedProfile {
  double minus_log_likelihood = 0.0;
  double sum_of_squares = 0.0;      ///< S = min of weighted squares + penalty; sigma^2 = S/N
  Eigen::VectorXd coefficients{};   ///< (p) generalised least-squares beta
  Eigen::MatrixXd information{};    ///< (p x p) X' V^-1 X, with V relative to sigma^2
  Eigen::MatrixXd spherical{};      ///< (q x G) v with b = L v
  bool is_valid = false;            ///< false if X' V^-1 X is not positive definite
  Eigen::MatrixXd by_factor{};      ///< (q x q) dF/dL, lower triangle
  Eigen::MatrixXd by_covariance{};  ///< (q x q) dF/dD, symmetric
};

/// F(L) = -log-likelihood = N/2 log(2 pi S/N) + N/2 + sum log|I + L'Z'G^-2 Z L| / 2 + sum log g.
/// Source: Pinheiro and Bates 2000, sections 2.2 and 5.2.
LinearMixedProfile profile(const LinearMixedModel& model,
                           const GroupMoments& moments,
                           double sum_log_scale,
                           const Eigen::MatrixXd& factor);

/// dF / d internal variance parameters at a profile.
Eigen::VectorXd variance_gradient(const LinearMixedModel& model,
                                  const GroupMoments& moments,
                                  const ResidualScale& scale,
                                  const Eigen::MatrixXd& factor,
                                  const LinearMixedProfile& at);

}  // namespace silvafit::fit
