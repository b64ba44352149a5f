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
  LindstromBatesState start(double spread) const;
  /// A start with the variance components that the model linear around the pooled fit asks for.
  LindstromBatesState first_order_start();
  bool has_variance_function() const { return variance_.parameter_count() > 0; }
  /// A start at the fit of the same model with constant variance.
  LindstromBatesState constant_variance_start(int maximum_iterations);
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
  LindstromBatesOutcome alternate(LindstromBatesState state,
                                  int maximum_iterations,
                                  bool hold_variance);
  Eigen::VectorXd factor_parameters(const Eigen::VectorXd& theta) const;
  Eigen::VectorXd variance_parameters(const Eigen::VectorXd& theta) const;
  bool linearise(const LindstromBatesState& state, Linearisation& at);
  const Eigen::VectorXd& variance_variable(const Linearisation& at) const;
  bool penalised_least_squares(LindstromBatesState& state, Linearisation& at);
  bool take_step(LindstromBatesState& state,
                 Linearisation& at,
                 const ResidualScale& scale,
                 const LinearMixedProfile& target);
  double profile_at(const Linearisation& at,
                    const Eigen::VectorXd& theta,
                    Eigen::VectorXd* gradient) const;
  LinearMixedProfile profile_of(const Linearisation& at, const Eigen::VectorXd& theta) const;

  const NonlinearModel& model_;
  std::vector<Eigen::Index> random_;
  Eigen::VectorXd scale_;  ///< (p) one unit of a scaled coefficient
  Eigen::VectorXd start_;  ///< (p) in scaled coordinates
  RelativeFactor factor_;
  VarianceModel variance_;
  Eigen::VectorXd variance_column_;  ///< (N), empty when of the fitted value
  NonlinearModel::Workspace workspace_;
};

}  // namespace silvafit::fit
