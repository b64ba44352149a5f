// SPDX-License-Identifier: MIT
// The likelihood of a nonlinear mixed model with the random effects integrated out, and its exact
// gradient.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "arrow_factor.hpp"
#include "observation_sums.hpp"
#include "quadrature_rule.hpp"

namespace silvafit::fit {

/// Parameters of the marginal likelihood.
struct MarginalPoint {
  ObservationPoint observation{};
  Eigen::MatrixXd outer_factor{};  ///< (s x s) L of the coarser grouping, Psi = L L'; may be empty
  Eigen::MatrixXd inner_factor{};  ///< (q x q) L of the only or the finer grouping
};

/// The value and its derivatives by the parameters.
struct MarginalValue {
  double minus_log_likelihood = 0.0;  ///< infinite where no mode was found
  Eigen::VectorXd by_beta{};          ///< (p)
  Eigen::VectorXd by_variance{};      ///< (m)
  double by_log_sigma = 0.0;
  Eigen::MatrixXd by_outer_factor{};  ///< (s x s) lower triangle
  Eigen::MatrixXd by_inner_factor{};  ///< (q x q) lower triangle
};

/// F = -log of the integral over the random effects b = L v, v ~ N(0, I), of each cluster:
/// Laplace's method with K as Curvature says, F_j = rho_j + v'v/2 + log|I + L'KL|/2 at the mode v;
/// or adaptive Gauss-Hermite quadrature around the mode.
///
/// Gradients are exact: modes are differentiated implicitly. Psi is never inverted, so that a
/// singular one is an ordinary point. Clusters are worked on in blocks whose sums are added in
/// order, so that the result does not depend on the number of threads.
/// Source: Pinheiro and Bates 1995, J. Comput. Graph. Stat. 4, 12-35.
class MarginalLikelihood {
 public:
  /// \param points  of quadrature a random effect; 1 is Laplace's method
  /// \throws UsageError if there are too many random effects for the method
  MarginalLikelihood(const NonlinearModel& model,
                     const VarianceModel& variance,
                     Curvature curvature,
                     int points,
                     unsigned threads);

  /// The value at a point; modes are searched from those of the last value that was finite.
  /// \param with_gradient  whether the derivatives are wanted
  MarginalValue evaluate(const MarginalPoint& point, bool with_gradient);

  /// Modes v of the random effects at the last value.
  const Eigen::MatrixXd& inner_modes() const { return inner_modes_; }  ///< (q x G)
  const Eigen::MatrixXd& outer_modes() const { return outer_modes_; }  ///< (s x clusters)
  /// Where the search for modes begins.
  void set_modes(Eigen::MatrixXd outer, Eigen::MatrixXd inner);

  /// Positions of the random effects of both groupings among the model's coefficients.
  const std::vector<Eigen::Index>& inner_coefficients() const { return inner_; }
  const std::vector<Eigen::Index>& outer_coefficients() const { return outer_; }

 private:
  class Block;
  void cut_into_blocks();
  RandomDesign design_of(const MarginalPoint& point) const;

  const NonlinearModel& model_;
  std::vector<Eigen::Index> outer_;
  std::vector<Eigen::Index> inner_;
  std::vector<Eigen::Index> outer_rows_;  ///< (s) rows of the random coefficients
  std::vector<Eigen::Index> inner_rows_;  ///< (q)
  ObservationSums sums_;
  QuadratureRule rule_;
  bool has_quadrature_ = false;
  unsigned threads_ = 1;
  std::vector<Eigen::Index> block_begin_;  ///< first cluster of each block
  Eigen::MatrixXd outer_modes_;
  Eigen::MatrixXd inner_modes_;
};

}  // namespace silvafit::fit
