// SPDX-License-Identifier: MIT
// The alternation of Lindstrom and Bates on one model, in coordinates of order one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "linear_mixed_profile.hpp"
#include "relative_factor.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "variance_weights.hpp"

namespace silvafit::fit {

/// Where an alternation stands.
struct LindstromBatesState {
  Eigen::VectorXd scale{};      ///< (p) one unit of each scaled coefficient
  Eigen::VectorXd beta{};       ///< (p) scaled coefficients
  Eigen::MatrixXd spherical{};  ///< (q x G) v with b = L v, scaled
  Eigen::VectorXd theta{};      ///< parameters of L, then of the variance function
};

/// How an alternation ended.
struct LindstromBatesOutcome {
  LindstromBatesState state{};
  double log_likelihood = 0.0;
  double decrement = 0.0;  ///< squared distance that theta would still move, in standard errors
  int iterations = 0;
  bool converged = false;
  bool is_valid = false;  ///< false where no finite point was reached
};

class LindstromBates {
 public:
  LindstromBates(const NonlinearModel& model, const Eigen::VectorXd& start);

  /// A start with all random effects zero and standard deviations of a typical size times `spread`.
  LindstromBatesState start(double spread);
  /// A start with the variance components that the model linear around the pooled fit asks for.
  LindstromBatesState first_order_start();
  bool has_variance_function() const { return variance_.parameter_count() > 0; }
  /// Holds the variance at a constant one in starts and runs, or lets it go.
  void hold_variance(bool hold);
  /// A state whose variance was held, with the variance function at its start.
  LindstromBatesState with_free_variance(const LindstromBatesState& held) const;
  /// How many short steps in a row penalised least squares may take before it gives up (6 at
  /// first).
  void set_patience(int short_steps) { short_steps_ = short_steps; }
  /// Alternates until both steps stand still.
  LindstromBatesOutcome run(LindstromBatesState state, int maximum_iterations);
  /// If the covariance stopped on the edge of its range although the likelihood rises inwards, a
  /// state inside.
  bool leave_edge(const LindstromBatesOutcome& outcome, LindstromBatesState& inside);
  /// The result in the model's own coordinates.
  MixedEffectsFit result(const LindstromBatesOutcome& outcome);

 private:
  /// The model linear around a state, with the residual scale there.
  struct Linearisation {
    LinearMixedModel model{};
    Eigen::VectorXd mean{};
    Eigen::VectorXd residual{};
  };
  /// The state with other variance components and the same random effects.
  LindstromBatesState with_theta(const LindstromBatesState& state,
                                 const Eigen::VectorXd& theta) const;
  Eigen::VectorXd factor_parameters(const Eigen::VectorXd& theta) const;
  Eigen::VectorXd variance_parameters(const Eigen::VectorXd& theta) const;
  /// Works in the units of a state from now on.
  void adopt_scale(const Eigen::VectorXd& scale);
  /// Measures a state in units that suit the linearisation at it, if they have changed by much.
  bool rescale(LindstromBatesState& state, Linearisation& at);
  bool linearise(const LindstromBatesState& state, Linearisation& at);
  bool penalised_least_squares(LindstromBatesState& state, Linearisation& at);
  /// (G) weighted squares of each group plus |v|^2.
  Eigen::VectorXd penalised_squares(const Linearisation& at,
                                    const Eigen::MatrixXd& spherical,
                                    const ResidualScale& scale) const;
  /// Moves towards the target while the penalised squares fall; the share of the way, 0 if none.
  double take_step(LindstromBatesState& state,
                   Linearisation& at,
                   const ResidualScale& scale,
                   const LinearMixedProfile& target);
  double profile_at(const Linearisation& at,
                    const Eigen::VectorXd& theta,
                    Eigen::VectorXd* gradient) const;
  LinearMixedProfile profile_of(const Linearisation& at, const Eigen::VectorXd& theta) const;

  const NonlinearModel& model_;
  std::vector<Eigen::Index> random_;
  Eigen::VectorXd start_;          ///< (p) coefficients of the pooled fit
  Eigen::VectorXd natural_scale_;  ///< (p) units at the pooled fit
  Eigen::VectorXd scale_;          ///< (p) units in use, those of the state at work
  RelativeFactor factor_;
  VarianceModel variance_;
  NonlinearModel::Workspace workspace_;
  int short_steps_ = 6;
  bool hold_variance_ = false;
};

}  // namespace silvafit::fit
