// SPDX-License-Identifier: MIT
// The contribution of some clusters to a marginal likelihood and its gradient.
#pragma once

#include <vector>

#include "conditional_modes/cluster_modes.hpp"
#include "conditional_modes/quadrature_rule.hpp"
#include "conditional_modes/random_places.hpp"
#include "likelihood/node_scale.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Parameters of the marginal likelihood.
struct MarginalPoint {
  ObservationPoint observation{};
  std::vector<MatrixXd> factors{};  ///< (q x q) L of each term, Psi = L L'
};

/// The value and its derivatives by the parameters.
struct MarginalValue {
  double minus_log_likelihood = 0.0;  ///< infinite if no mode was found
  VectorXd by_beta{};                 ///< (p)
  VectorXd by_variance{};             ///< (m)
  double by_log_sigma = 0.0;
  std::vector<MatrixXd> by_factors{};  ///< (q x q); only the lower triangles are used

  static MarginalValue zero(const MarginalPoint& point);
  void add(const MarginalValue& other);
  /// All numbers in one vector.
  VectorXd numbers() const;
  void set_numbers(const VectorXd& numbers);
};

/// Differences of the parameters of the likelihood from those of another point.
struct PointChange {
  ObservationPoint observation{};
  RandomDesign design{};
};

/// Consecutive clusters, with memory that is reused by the next evaluation.
class MarginalBlock {
 public:
  /// \param rule  of quadrature, null for Laplace's method
  MarginalBlock(const NonlinearModel& model,
                const EffectLayout& layout,
                const GroupSums& sums,
                const RandomPlaces& places,
                const QuadratureRule* rule,
                Index first,
                Index last);

  /// \param modes    (layout) in: starts of the search for modes; out: modes
  /// \param effects  (r x G) memory for the random effects of all groups
  MarginalValue value(const MarginalPoint& point,
                      const RandomDesign& design,
                      VectorXd& modes,
                      MatrixXd& effects,
                      GroupSums::Workspace& workspace,
                      bool with_gradient);

  /// Searches modes without computing the likelihood.
  /// \param known       as in ClusterModes::search
  /// \param objectives  (C) out: the minimized objective; infinite if the mode is a known one
  /// \returns false if a conditional mode is flat
  bool find_modes(const RandomDesign& design,
                  VectorXd& modes,
                  MatrixXd& effects,
                  GroupSums::Workspace& workspace,
                  const VectorXd* known,
                  VectorXd& objectives);

  /// Stores the derivatives of the modes of the last evaluation, which must have had a gradient, by
  /// the parameters.
  void keep(const RandomDesign& design);
  /// Moves the stored modes to first order for a change of the parameters; modes with a large
  /// change are not moved.
  /// \param modes  in: the stored ones
  void follow(const PointChange& change, VectorXd& modes);

 private:
  bool factorize_determinants(const RandomDesign& design);
  bool has_clear_modes() const;
  /// (r) change of the gradient of a group by its random effects at the stored modes.
  SmallVector slope_change(const PointChange& change,
                           const SmallMatrix& curvature,
                           Index cluster,
                           Index group) const;
  EffectFactor& determinant(Index cluster);
  const EffectFactor& determinant(Index cluster) const;
  void integrate(const MarginalPoint& point,
                 const RandomDesign& design,
                 MatrixXd& effects,
                 GroupSums::Workspace& workspace,
                 MarginalValue& result,
                 bool with_gradient);
  /// \param node_sums  out: by node, one column per group
  void evaluate_nodes(const RandomDesign& design,
                      MatrixXd& effects,
                      GroupSums::Workspace& workspace,
                      std::vector<MatrixXd>& node_sums,
                      bool with_gradient);
  void add_node_slopes(const MarginalPoint& point,
                       const std::vector<MatrixXd>& node_sums,
                       Index group,
                       MarginalValue& result);
  void place_nodes(const RandomDesign& design);
  void differentiate(const RandomDesign& design,
                     MatrixXd& effects,
                     GroupSums::Workspace& workspace,
                     MarginalValue& result);
  void weigh(const SmallMatrix& joint, MatrixXd& weights);
  void follow_modes(const RandomDesign& design);
  void add_group(const RandomDesign& design,
                 Index cluster,
                 Index group,
                 MarginalValue& result) const;
  void add_coefficients(Index group,
                        const SmallVector& shift,
                        const SmallVector& bend,
                        MarginalValue& result) const;

  const NonlinearModel& model_;
  const GroupSums& sums_;
  const RandomPlaces& places_;
  const QuadratureRule* rule_;
  Index r_;
  ClusterModes modes_;
  std::vector<EffectFactor> determinants_;  ///< with K for the curvature; empty if it is the same
  MatrixXd weights_;                        ///< (triangle x groups) the matrices M
  MatrixXd totals_;                         ///< sums of total terms, one column per group
  /// (joint effects squared x groups) replaces H^-1 in derivatives of the log-determinant
  MatrixXd spread_;
  /// Derivatives of the value by the modes, then of the modes by the parameters.
  VectorXd follow_;
  // At the stored modes:
  RandomDesign kept_design_;
  VectorXd kept_modes_;
  MatrixXd kept_density_;
  MatrixXd kept_totals_;
  EffectFactor kept_hessian_;  ///< of the current cluster
  // For quadrature:
  std::vector<MatrixXd> nodes_;    ///< (q x nodes) by group
  std::vector<NodeScale> scales_;  ///< by group
  MatrixXd shares_;                ///< (nodes x groups) of each node in the integral
  MatrixXd mode_slopes_;           ///< sums of slope terms at the modes
};

}  // namespace silvafit::fit
