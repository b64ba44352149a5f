// SPDX-License-Identifier: MIT
// What some clusters add to a marginal likelihood and its gradient.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "conditional_modes/cluster_modes.hpp"
#include "conditional_modes/quadrature_rule.hpp"
#include "conditional_modes/random_places.hpp"

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
  Eigen::MatrixXd by_outer_factor{};  ///< (s x s); its lower triangle counts
  Eigen::MatrixXd by_inner_factor{};  ///< (q x q); its lower triangle counts

  static MarginalValue zero(const MarginalPoint& point);
  void add(const MarginalValue& other);
  /// All numbers in one vector.
  Eigen::VectorXd numbers() const;
  void set_numbers(const Eigen::VectorXd& numbers);
};

/// How the parameters of the likelihood differ from those of another point.
struct PointChange {
  ObservationPoint observation{};
  RandomDesign design{};
};

/// Consecutive clusters, with memory that is kept from one value to the next.
class MarginalBlock {
 public:
  /// \param rule  of quadrature, null for Laplace's method
  MarginalBlock(const NonlinearModel& model,
                const ObservationSums& sums,
                const RandomPlaces& places,
                const QuadratureRule* rule,
                Eigen::Index first,
                Eigen::Index last);

  /// \param modes    in: where the search for modes begins; out: modes
  /// \param effects  (r x G) room for the random effects of all groups
  MarginalValue value(const MarginalPoint& point,
                      const RandomDesign& design,
                      Modes& modes,
                      Eigen::MatrixXd& effects,
                      ObservationSums::Workspace& workspace,
                      bool with_gradient);

  /// Searches modes without a value.
  /// \param known       as in ClusterModes::search
  /// \param objectives  (C) out: what modes minimize, infinite where the mode is a known one
  /// \returns false if a conditional mode is flat
  bool find_modes(const RandomDesign& design,
                  Modes& modes,
                  Eigen::MatrixXd& effects,
                  ObservationSums::Workspace& workspace,
                  const Modes* known,
                  Eigen::VectorXd& objectives);

  /// Keeps how the modes of the last value, which must have had a gradient, follow the parameters.
  void keep(const RandomDesign& design);
  /// Moves the kept modes as far as a change of the parameters moves them, to first order; modes
  /// that it moves far stay where they are.
  /// \param modes  in: the kept ones
  void follow(const PointChange& change, Modes& modes);

 private:
  bool factorize_determinants(const RandomDesign& design);
  bool has_clear_modes() const;
  /// (r) how the slope of a group by its random effects changes at the kept modes.
  SmallVector slope_change(const PointChange& change,
                           const SmallMatrix& curvature,
                           Eigen::Index cluster,
                           Eigen::Index group) const;
  const ArrowFactor& determinant(Eigen::Index cluster) const;
  void integrate(const MarginalPoint& point,
                 const RandomDesign& design,
                 Eigen::MatrixXd& effects,
                 ObservationSums::Workspace& workspace,
                 MarginalValue& result,
                 bool with_gradient);
  /// \param node_sums  out: by node, one column a group
  void evaluate_nodes(const RandomDesign& design,
                      Eigen::MatrixXd& effects,
                      ObservationSums::Workspace& workspace,
                      std::vector<Eigen::MatrixXd>& node_sums,
                      bool with_gradient);
  void add_node_slopes(const MarginalPoint& point,
                       const std::vector<Eigen::MatrixXd>& node_sums,
                       Eigen::Index group,
                       MarginalValue& result);
  SmallVector node(Eigen::Index group, Eigen::Index number) const;
  void differentiate(const RandomDesign& design,
                     Eigen::MatrixXd& effects,
                     ObservationSums::Workspace& workspace,
                     MarginalValue& result);
  void weigh(const SmallMatrix& joint, Eigen::MatrixXd& weights);
  void follow_modes(const RandomDesign& design);
  void add_group(const RandomDesign& design,
                 const SmallMatrix& joint,
                 Eigen::Index cluster,
                 Eigen::Index group,
                 MarginalValue& result) const;
  void add_coefficients(Eigen::Index group,
                        const SmallVector& shift,
                        const SmallVector& bend,
                        MarginalValue& result) const;

  const NonlinearModel& model_;
  const ObservationSums& sums_;
  const RandomPlaces& places_;
  const QuadratureRule* rule_;
  Eigen::Index r_;
  ClusterModes modes_;
  std::vector<ArrowFactor> determinants_;  ///< with K for the curvature; empty where it is the same
  Eigen::MatrixXd weights_;                ///< (triangle x groups) the matrices M
  Eigen::MatrixXd totals_;                 ///< sums of total terms, one column a group
  /// (s + q squared x groups) what takes the place of H^-1 in derivatives of the log-determinant
  Eigen::MatrixXd spread_;
  /// How the value follows the modes, then how they follow the parameters: (s x clusters), (q x
  /// groups).
  Eigen::MatrixXd outer_follow_;
  Eigen::MatrixXd inner_follow_;
  // At the modes that are kept:
  RandomDesign kept_design_;
  Eigen::MatrixXd kept_outer_;
  Eigen::MatrixXd kept_inner_;
  Eigen::MatrixXd kept_density_;
  Eigen::MatrixXd kept_totals_;
  ArrowFactor kept_hessian_;  ///< of the cluster at work
  // For quadrature:
  Eigen::MatrixXd shares_;       ///< (nodes x groups) of each node in the integral
  Eigen::MatrixXd mode_slopes_;  ///< sums of slope terms at the modes
};

}  // namespace silvafit::fit
