// SPDX-License-Identifier: MIT
// The likelihood of a nonlinear mixed model with the random effects integrated out, and its exact
// gradient.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "likelihood/marginal_block.hpp"
#include "likelihood/shared_clusters.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The curvature that stands in the log-determinant of a method's likelihood.
Curvature curvature_of(Method method);

/// F = -log of the integral over the random effects b = L v, v ~ N(0, I), of each cluster:
/// Laplace's method with K of Curvature, F_j = rho_j + v'v/2 + log|I + L'KL|/2 at the mode v;
/// or adaptive Gauss-Hermite quadrature around the mode.
///
/// Gradients are exact: modes are differentiated implicitly. Psi is never inverted, so that a
/// singular one is an ordinary point. Clusters are processed in blocks whose sums are added in
/// order, so that the result does not depend on the number of threads or of ranks.
/// Source: Pinheiro and Bates 1995, J. Comput. Graph. Stat. 4, 12-35.
class MarginalLikelihood {
 public:
  /// \param points  of quadrature per random effect; 1 is Laplace's method
  /// \param shared  the model's clusters among those of all ranks; null: a single rank
  /// \throws UsageError if there are too many random effects for the method
  MarginalLikelihood(const NonlinearModel& model,
                     const VarianceModel& variance,
                     Curvature curvature,
                     int points,
                     const SharedClusters* shared = nullptr);

  /// The value at a point; modes are searched from those of the last value that was finite.
  /// \param with_gradient  whether to compute the derivatives
  MarginalValue evaluate(const MarginalPoint& point, bool with_gradient);

  /// Searches modes at a point.
  /// \param modes  in: starts; out: modes
  /// \param known  other modes, or null: searches near them are stopped
  /// \returns (C) the minimized objective, except for a constant; infinite if the mode is a known
  ///   one. No value if a search ends at a flat conditional mode.
  std::optional<VectorXd> find_modes(const MarginalPoint& point,
                                     VectorXd& modes,
                                     const VectorXd* known);

  /// Modes of the random effects at the last value.
  const VectorXd& modes() const { return modes_; }
  /// Sets the starts of the search for modes.
  void set_modes(VectorXd modes);
  /// Stores the modes of the last evaluation, which must have been finite and with a gradient, ...
  void keep_modes(const MarginalPoint& point);
  /// ... and starts the next search from these, moved to first order by the change of the
  /// parameters.
  void set_kept_modes();

  /// Indices of the random effects of all terms among the model's coefficients.
  const RandomPlaces& places() const { return places_; }
  /// The order of the modes.
  const EffectLayout& layout() const { return layout_; }

 private:
  void cut_into_blocks();
  void add_block(const QuadratureRule* rule, Index first, Index last);
  RandomDesign design_of(const MarginalPoint& point) const;
  MarginalValue total_of(const std::vector<MarginalValue>& parts, const MarginalPoint& point) const;
  MarginalValue value(const MarginalPoint& point, bool with_gradient, const PointChange* change);

  const NonlinearModel& model_;
  const SharedClusters* shared_;
  RandomPlaces places_;
  EffectLayout layout_;
  std::unique_ptr<GroupSums> sums_;
  QuadratureRule rule_;
  std::vector<std::unique_ptr<MarginalBlock>> blocks_;
  std::vector<GroupSums::Workspace> workspaces_;  ///< by worker
  VectorXd modes_;
  VectorXd kept_;
  MarginalPoint kept_at_;
  bool starts_from_kept_ = false;
  MatrixXd effects_;  ///< (r x G) memory for the random effects b
};

}  // namespace silvafit::fit
