// SPDX-License-Identifier: MIT
// The alternation of Lindstrom and Bates on one model, in coordinates of order one.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "likelihood/linear_mixed_profile.hpp"
#include "likelihood/linearization.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/relative_factor.hpp"
#include "model/variance_weights.hpp"
#include "optimization/quasi_newton.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The state of an alternation.
struct LindstromBatesState {
  /// One unit of each scaled coefficient, also of those with random effects only.
  VectorXd scale{};
  /// M with coefficients = M scale beta, of these columns; empty where it is the identity.
  MatrixXd mixing{};
  VectorXd beta{};                    ///< (p) scaled coefficients
  std::vector<MatrixXd> spherical{};  ///< (q x groups) of each term: v with b = L v, scaled
  VectorXd theta{};                   ///< parameters of L of each term, of the variance function

  /// The squares of the spherical effects.
  double penalty() const;
};

/// The end of an alternation.
struct LindstromBatesOutcome {
  LindstromBatesState state{};
  std::shared_ptr<const Linearization> at{};  ///< the model around the state
  double log_likelihood = 0.0;
  double decrement = 0.0;        ///< Newton decrement of theta
  double curve_decrement = 0.0;  ///< Newton decrement of the coefficients
  int iterations = 0;
  bool converged = false;
  bool is_limit = false;  ///< whether it has converged to a range or power without bound
  bool is_valid = false;  ///< false if no finite point was reached
  Obstacle obstacle{};    ///< the reason if it did not converge
};

/// The work of runs.
struct LindstromBatesWork {
  int passes = 0;  ///< over the data, to linearize the model
  int alternations = 0;

  LindstromBatesWork& operator+=(const LindstromBatesWork& other) {
    passes += other.passes;
    alternations += other.alternations;
    return *this;
  }
};

/// A fit as the start of one with a larger variance function.
struct SmallerVariance {
  LindstromBatesState state{};
  std::vector<VarianceModel::Quantity> quantities{};
  VectorXd parameters{};  ///< internal, of the variance function
  double mean_log = 0.0;  ///< mean of log g
  double log_likelihood = 0.0;
  bool converged = false;
};

/// The order of the two steps.
enum class Alternation {
  /// One step of each per iteration; if a step of the coefficients differs from the prediction of
  /// the linear model, a careful iteration.
  kInterleaved,
  /// Penalized least squares to convergence, with short steps if necessary, then theta likewise.
  kCareful,
};

/// How penalized least squares ended.
enum class SquaresEnd {
  kReached,
  kRounded,  ///< at a minimum up to rounding errors, which are above the tolerance
  kLimit,    ///< at the limit of steps, with lower squares than before, but not at a minimum
  kFailed,
};

/// The model at the coefficients of the pooled fit (without groups).
struct PooledFit {
  VectorXd coefficients{};      ///< (p)
  VectorXd scale{};             ///< units in which all columns of the Jacobian have size one
  MatrixXd mixing{};            ///< orthogonalizes nearly dependent columns, or empty
  double log_likelihood = 0.0;  ///< of the model without random effects, nested in all others
};
PooledFit pooled_fit(const NonlinearModel& model,
                     const VectorXd& start,
                     const MixedEffectsOptions& options);

class LindstromBates {
 public:
  /// \param pooled    the fit without random effects
  /// \param variance       the model's own variance function, or one that it contains
  /// \param is_correlated  whether the residuals have the model's correlation, or none
  LindstromBates(const NonlinearModel& model,
                 const PooledFit& pooled,
                 const VarianceFunction& variance,
                 const MixedEffectsOptions& options,
                 bool is_correlated = true);

  /// A start with all random effects zero and standard deviations of a typical size times `spread`.
  LindstromBatesState start(double spread);
  /// A start with the variance components of the model linearized at the pooled fit.
  LindstromBatesState first_order_start();
  /// The start of a larger variance function.
  SmallerVariance variance_of(const LindstromBatesOutcome& outcome) const;
  /// A start from a fit whose variance function is nested in this one.
  /// \param factors_of  for each factor of the smaller function, its index in this function
  LindstromBatesState start_from(const SmallerVariance& smaller,
                                 const std::vector<std::size_t>& factors_of);
  /// The state at the maxima of the linearized likelihood that are reached from all starts of the
  /// residuals' variance function and correlation; the state alone if there is one start only.
  std::vector<LindstromBatesState> with_residuals(const LindstromBatesState& state);
  /// States where the linearized likelihood is higher than at the end of a run, reached from other
  /// sizes of effects that share a variance, and from variance functions of the other sign.
  std::vector<LindstromBatesState> other_maxima(const LindstromBatesOutcome& outcome);
  /// Whether the range of the correlation is far above all distances.
  bool has_unbounded_range(const LindstromBatesState& state) const;
  /// Whether a run has converged to a range, or a power of the variance function, without bound.
  bool is_limit(const LindstromBatesOutcome& outcome);
  /// A start at a fit of the same model to the same or other data.
  LindstromBatesState start_at(const MixedEffectsFit& fit);
  /// Maximum number of consecutive short steps of penalized least squares (default 6).
  void set_short_step_limit(int short_steps) { short_steps_ = short_steps; }
  /// Maximum number of linearizations of the following runs; one is a pass over the data.
  void set_passes(int passes) { passes_left_ = passes; }
  /// The work of all runs.
  const LindstromBatesWork& work() const { return work_; }
  /// Newton decrement of theta below which an alternation has converged.
  void set_tolerance(double decrement) { tolerance_ = decrement; }
  /// Alternates until both steps leave the estimates unchanged.
  LindstromBatesOutcome run(LindstromBatesState state, Alternation how);
  /// If a covariance is singular, or the correlation at an end of its range, although the
  /// likelihood is higher in the interior, a state inside.
  bool leave_boundary(const LindstromBatesOutcome& outcome, LindstromBatesState& inside);
  /// The result in the model's own coordinates.
  MixedEffectsFit result(const LindstromBatesOutcome& outcome);

 private:
  class Run;
  bool leave_singular_covariance(const LindstromBatesOutcome& outcome, LindstromBatesState& inside);
  /// Correlations that may be higher than one where a run has ended: from an end, the structure's
  /// starts, and their ranges with the other parameters; ranges beside that of a kinked likelihood.
  std::vector<VectorXd> other_correlations(const VectorXd& now) const;
  bool leave_end_of_correlation(const LindstromBatesOutcome& outcome, LindstromBatesState& inside);
  /// Steps of the variance components per iteration: sufficient after the linearization has
  /// converged; more are useless before that.
  static constexpr int kThetaSteps = 30;
  /// A descent that is sufficient to choose the starts of runs.
  static constexpr QuasiNewtonOptions kRoughly{
      .decrement = 1e-5, .maximum_steps = 30, .one_sided = true};
  /// The largest tolerance of penalized least squares.
  static constexpr double kLoosestSquares = 1e-7;

  Index random_parameter_count() const;
  /// Calls visit(term, factor, begin) for each term, whose parameters in theta begin there; the
  /// last term is first.
  template <typename Visit>
  void for_each_term(const Visit& visit) const {
    Index begin = 0;
    for (std::size_t t = factors_.size(); t-- > 0;) {
      visit(t, factors_[t], begin);
      begin += factors_[t].parameter_count();
    }
  }
  RelativeFactors factors(const VectorXd& theta) const;
  /// Sets the parameters of all factors in theta.
  void set_factors(const RelativeFactors& factors, VectorXd& theta) const;
  void make_factors();
  VectorXd variance_parameters(const VectorXd& theta) const {
    return theta.tail(variance_.parameter_count());
  }
  /// The state with other variance components and the same random effects.
  LindstromBatesState with_theta(const LindstromBatesState& state, const VectorXd& theta) const;
  /// Uses the units of a state in the following steps.
  void adopt_units(const VectorXd& scale, const MatrixXd& mixing);
  /// (k x n) coefficients in their own units from those of some columns, including all columns that
  /// these are mixed with.
  MatrixXd own_values(const std::vector<Index>& columns, const MatrixXd& scaled) const;
  /// The inverse of own_values.
  MatrixXd scaled_values(const std::vector<Index>& columns, const MatrixXd& own) const;
  /// Converts a state to units of the linearization at it, if these have changed much.
  bool rescale(LindstromBatesState& state, Linearization& at);
  /// Orthogonalizes nearly dependent columns at a state, if its units do not.
  bool remix(LindstromBatesState& state, Linearization& at);
  /// log|X'V^-1 X| in own units less that of scaled columns.
  double log_units() const;
  /// (columns x G) random effects of a state in the coefficients' own units.
  MatrixXd own_effects(const LindstromBatesState& state) const;
  bool linearize(const LindstromBatesState& state, const Linearization* before, Linearization& at);
  /// Minimizes the penalized squares of the random effects and coefficients.
  /// \param tolerance  squared standard errors within which slow convergence ends the search
  SquaresEnd penalized_least_squares(LindstromBatesState& state,
                                     Linearization& at,
                                     double tolerance = kLoosestSquares);
  /// Moves towards the target while the penalized squares decrease; returns the step length
  /// relative to the whole, 0 if none.
  double take_step(LindstromBatesState& state, Linearization& at, const LinearMixedProfile& target);
  /// Variance components and the linearized likelihood there.
  struct Start {
    VectorXd theta{};
    double value = 0.0;  ///< minus the log-likelihood
  };
  /// The lowest ends of short descents from some starts.
  std::vector<Start> ends_of(const LindstromBatesState& state, const std::vector<Start>& starts);
  /// Those from the starts of the variance function.
  std::vector<Start> variance_ends(const LindstromBatesState& state);
  /// All starts of the correlation around a state, with variance components of the state and
  /// others.
  std::vector<Start> correlation_starts(const LindstromBatesState& state);
  /// The lowest starts, of which no two have the same likelihood, or first parameters of the
  /// correlation that are near each other.
  /// \param higher  those higher than the lowest one by more are left out
  std::vector<Start> lowest(std::vector<Start> starts,
                            std::size_t most,
                            double apart,
                            double higher) const;
  /// A typical standard deviation of the effects of a term in scaled coordinates, relative to that
  /// of the residuals.
  double typical_deviation(std::size_t term) const;
  std::vector<VectorXd> distant_thetas(const LindstromBatesOutcome& outcome) const;
  /// Moves a state to the variance components at the maximum of the linearized likelihood.
  /// \returns the last descent; without x if none succeeded
  QuasiNewtonResult settle(LindstromBatesState& state);
  /// The minimum of the linearized likelihood around a state.
  QuasiNewtonResult best_theta(const LindstromBatesState& state, const QuasiNewtonOptions& options);
  LinearMixedProfile profile_at(const Linearization& at,
                                const VectorXd& theta,
                                bool with_derivatives) const;
  /// The profile of the model linear around a state, at any theta.
  LinearMixedProfile profile_near(const LindstromBatesState& state,
                                  const Linearization& at,
                                  const VectorXd& theta);
  VectorXd gradient(const VectorXd& theta, const LinearMixedProfile& at) const;

  const NonlinearModel& model_;
  MixedEffectsOptions options_;
  std::string variance_text_;               ///< for the trace
  std::vector<std::vector<Index>> random_;  ///< coefficients with effects of each term
  PooledFit pooled_;
  std::vector<Index> all_;               ///< 0, ..., p - 1
  VectorXd scale_;                       ///< units in use, those of the current state
  MatrixXd mixing_;                      ///< in use, or empty
  std::vector<RelativeFactor> factors_;  ///< of each term, in the units in use
  VarianceModel variance_;
  bool is_normalized_;
  Linearizer linearizer_;
  double tolerance_ = 1e-14;
  int short_steps_ = 6;
  int passes_left_ = std::numeric_limits<int>::max();
  LindstromBatesWork work_;
};

}  // namespace silvafit::fit
