// SPDX-License-Identifier: MIT
// One run of the alternation of Lindstrom and Bates, from a state to a fixed point of both steps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "model/kinked_range.hpp"
#include "optimization/fixed_point.hpp"
#include "optimization/kinked_minimum.hpp"
#include "optimization/quasi_newton.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
/// One run of the alternation.
class LindstromBates::Run {
 public:
  Run(LindstromBates& engine, LindstromBatesState state, Alternation how)
      : engine_(engine), state_(std::move(state)), last_(state_), how_(how) {}

  LindstromBatesOutcome run() {
    engine_.adopt_units(state_.scale, state_.mixing);
    if (!begin()) return outcome_;
    for (int iteration = 1; iteration <= engine_.options_.maximum_iterations; ++iteration) {
      if (engine_.rescale(state_, *at_)) {
        mixing_.restart();
        hessian_.resize(0, 0);
      }
      ++engine_.work_.alternations;
      if (!optimize_theta()) return ended({.cause = Finding::Kind::kLinearModelInvalid});
      note(iteration);
      if (outcome_.converged) return outcome_;
      if (effects_have_diverged()) {
        return ended(
            {.status = ConvergenceStatus::kDiverged, .cause = Finding::Kind::kEffectsDiverge});
      }
      if (gives_up()) return ended({.cause = Finding::Kind::kStepsDoNotSettle});
      if (!advance()) {
        if (engine_.passes_left_ <= 0) {
          return ended(
              {.status = ConvergenceStatus::kIterationLimit, .cause = Finding::Kind::kPassLimit});
        }
        return ended(
            {.status = ConvergenceStatus::kDiverged, .cause = Finding::Kind::kSquaresDiverge});
      }
    }
    return ended(
        {.status = ConvergenceStatus::kIterationLimit, .cause = Finding::Kind::kIterationLimit});
  }

 private:
  LindstromBatesOutcome ended(Obstacle obstacle) {
    outcome_.obstacle = std::move(obstacle);
    return outcome_;
  }

  /// The method has no fixed point for some data with small groups: its two steps then never
  /// converge. True when many alternations have not halved the best decrement.
  bool stagnates() {
    constexpr int kPatience = 15;
    const double decrement = outcome_.decrement;
    if (decrement < 0.5 * best_decrement_) {
      best_decrement_ = decrement;
      waited_ = 0;
    }
    return ++waited_ > kPatience;
  }

  /// Whether the likelihood has decreased far below its earlier value and stays there: effects of
  /// groups have diverged to a region where the mean no longer depends on them.
  bool effects_have_diverged() {
    constexpr double kFar = 0.5;  // log-likelihood units per observation
    constexpr int kLongFall = 5;
    highest_ = std::max(highest_, here_);
    const double fall = highest_ - here_;
    lost_ = fall > kFar * static_cast<double>(engine_.model_.observations()) ? lost_ + 1 : 0;
    return lost_ >= kLongFall;
  }

  bool gives_up() {
    if (!stagnates()) return false;
    if (how_ == Alternation::kCareful) return true;
    how_ = Alternation::kCareful;
    best_decrement_ = kInfinity;
    waited_ = 0;
    mixing_.restart();
    return false;
  }

  bool begin() {
    at_ = std::make_shared<Linearization>();
    if (how_ == Alternation::kCareful) {
      squares_end_ = engine_.penalized_least_squares(state_, *at_);
      return squares_end_ != SquaresEnd::kFailed;
    }
    return engine_.linearize(state_, nullptr, *at_);
  }

  const LinearMixedProfile& profile(const VectorXd& theta) {
    if (profile_theta_.size() != theta.size() || profile_theta_ != theta ||
        profiled_ != at_.get()) {
      profile_ = engine_.profile_near(state_, *at_, theta);
      profile_theta_ = theta;
      profiled_ = at_.get();
    }
    return profile_;
  }

  bool optimize_theta() {
    profiled_ = nullptr;
    const LinearMixedProfile& here = profile(state_.theta);
    if (!here.is_valid) return false;
    here_ = -here.minus_log_likelihood;
    const double squares = at_->squares.sum() + state_.penalty();
    curve_decrement_ = (squares - here.sum_of_squares) / here.sigma2;
    const SmoothFunction objective = [&](const VectorXd& theta, VectorXd* by_theta) {
      const LinearMixedProfile& value = profile(theta);
      if (!value.is_valid) return kInfinity;
      if (by_theta != nullptr) *by_theta = engine_.gradient(theta, value);
      return value.minus_log_likelihood;
    };
    // Before convergence, more digits than the accuracy of the linearization are useless.
    constexpr double kShare = 1e-3;
    QuasiNewtonOptions options{.maximum_steps = kThetaSteps, .one_sided = true};
    if (how_ == Alternation::kInterleaved) {
      options.decrement = std::max(options.decrement, kShare * std::min(1.0, curve_decrement_));
    }
    best_ = minimize(objective, state_.theta, hessian_, options);
    if (has_kinked_range(engine_.variance_.correlated()) && best_.decrement > options.decrement) {
      settle_at_kinks(objective);
    }
    if (!best_.x.allFinite()) return false;
    hessian_ = best_.hessian;
    return true;
  }

  void settle_at_kinks(const SmoothFunction& objective) {
    const auto found = minimum_at_kinks(objective, best_.x);
    if (!found || !(found->value <= best_.value + kRoundedLikelihood)) return;
    best_.x = found->x;
    best_.value = found->value;
    best_.hessian = found->hessian;
    best_.decrement = found->decrement;
  }

  /// Whether the coefficients are at their penalized least squares, given the variance components.
  bool coefficients_have_settled() const {
    if (how_ == Alternation::kCareful) {
      return squares_end_ == SquaresEnd::kRounded || curve_decrement_ <= kLoosestSquares;
    }
    // Movements of the coefficients below the rounding error of the sums of squares are not
    // visible. That of a factorization grows with the root of the number of its effects.
    double rounding = 1e-15 * static_cast<double>(engine_.model_.observations());
    if (engine_.model_.crossed() != nullptr) {
      Index effects = 0;
      for (const MatrixXd& of_term : state_.spherical) effects += of_term.size();
      rounding *= std::sqrt(static_cast<double>(effects));
    }
    return curve_decrement_ <= std::max(engine_.tolerance_, rounding);
  }

  void note(int iteration) {
    const VectorXd change = best_.x - state_.theta;
    outcome_.state = state_;
    outcome_.at = at_;
    outcome_.log_likelihood = here_;
    outcome_.iterations = iteration;
    outcome_.is_valid = true;
    outcome_.decrement = change.size() > 0 ? change.dot(hessian_ * change) : 0.0;
    // Rounding errors of nearly dependent columns that end penalized least squares also move theta.
    constexpr double kMostRounding = 1e-8;
    const double tolerance =
        squares_end_ == SquaresEnd::kRounded
            ? std::max(engine_.tolerance_, std::min(curve_decrement_, kMostRounding))
            : engine_.tolerance_;
    outcome_.converged = outcome_.decrement <= tolerance && coefficients_have_settled();
    outcome_.curve_decrement = curve_decrement_;
    if (!engine_.options_.trace) return;
    engine_.options_.trace(
        fmt::format("variance {}: iteration {}, log-likelihood {:.6f}, change of variance "
                    "components {:.1e} and of coefficients {:.1e} standard errors, step {:.3g}",
                    engine_.variance_text_,
                    iteration,
                    here_,
                    std::sqrt(std::max(0.0, outcome_.decrement)),
                    std::sqrt(std::max(0.0, curve_decrement_)),
                    length_));
  }

  /// Computes the linearization of the next iteration.
  bool advance() {
    last_ = state_;
    VectorXd theta = mixing_.next(state_.theta, best_.x);
    if (loses(theta)) theta = best_.x;
    if (how_ == Alternation::kInterleaved) {
      if (!profile(theta).is_valid) theta = best_.x;
      if (interleaved_step(theta)) return true;
    }
    return careful_step(theta);
  }

  /// Whether an extrapolation has left the region of the maximum: steps of the longest length of a
  /// variance function look like those of slow convergence to a far point, and the likelihood is
  /// flat towards the limits of a correlation, such as a nugget of 0, so that it may cross to the
  /// other one.
  bool loses(const VectorXd& theta) {
    // The way of constant-plus-power to a power or a constant leads over flat regions.
    const auto has_constant = [](const VarianceFactor& of) { return kind_of(of).has_constant(); };
    const bool is_flat =
        engine_.variance_.correlated() == nullptr &&
        std::ranges::any_of(engine_.model_.specification().variance.factors, has_constant);
    if (engine_.variance_.parameter_count() == 0 || is_flat) return false;
    const LinearMixedProfile& there = profile(theta);
    return !there.is_valid || -there.minus_log_likelihood < here_ - kHigher;
  }

  /// The solution of the linear model, if the nonlinear model agrees with it there.
  bool interleaved_step(const VectorXd& theta) {
    const LinearMixedProfile& target = profile(theta);
    if (!target.is_valid) return false;
    LindstromBatesState trial = state_;
    trial.theta = theta;
    trial.beta += target.coefficients;
    trial.spherical = target.spherical;
    auto point = std::make_shared<Linearization>();
    if (!engine_.linearize(trial, at_.get(), *point)) return refuse();
    const VectorXd expected = expected_squares(at_->model, engine_.factors(theta), target);
    // Crossed terms have only the sum: their effects move many groups.
    const bool has_groups = expected.size() == point->squares_before.size();
    const double excess = point->squares_before.sum() - expected.sum();
    const double most = has_groups ? (point->squares_before - expected).maxCoeff() : excess;
    const double total = at_->squares.sum();
    const double penalty = trial.penalty() - state_.penalty();
    const double gain = std::max(0.0, total - expected.sum() - penalty);
    // At least half of the predicted gain is required; while theta changes, the squares may
    // increase by a hundredth.
    constexpr double kLoss = 0.01;
    constexpr double kRunsOff = 0.1;
    if (excess > 0.5 * gain + kLoss * expected.sum() || most > kRunsOff * total) {
      return refuse();
    }
    state_ = std::move(trial);
    at_ = std::move(point);
    squares_end_ = SquaresEnd::kReached;
    length_ = 1.0;
    return true;
  }

  /// After several refused solutions the linear model is not used.
  bool refuse() {
    constexpr int kRefusals = 3;
    if (++refusals_ >= kRefusals) how_ = Alternation::kCareful;
    return false;
  }

  bool careful_step(const VectorXd& theta) {
    // Errors of the coefficients change the variance components, which must settle.
    constexpr double kShare = 0.01;
    const double tolerance = std::min(kLoosestSquares, kShare * outcome_.decrement);
    // Shorter steps of the variance components make no progress.
    constexpr double kShortestMove = 1e-2;
    VectorXd target = theta;
    for (length_ = 1.0; length_ >= kShortestMove; length_ *= 0.5) {
      LindstromBatesState trial = engine_.with_theta(last_, target);
      auto point = std::make_shared<Linearization>();
      squares_end_ = engine_.penalized_least_squares(trial, *point, tolerance);
      if (squares_end_ != SquaresEnd::kFailed) {
        state_ = std::move(trial);
        at_ = std::move(point);
        return true;
      }
      // The mean function is not finite there: a shorter step from the last state.
      mixing_.restart();
      target = last_.theta + 0.5 * length_ * (theta - last_.theta);
    }
    return false;
  }

  LindstromBates& engine_;
  LindstromBatesState state_;
  LindstromBatesState last_;  // after the last success of both steps
  Alternation how_;
  std::shared_ptr<Linearization> at_;
  LindstromBatesOutcome outcome_;
  AndersonMixing mixing_{4};
  MatrixXd hessian_;
  QuasiNewtonResult best_;
  SquaresEnd squares_end_ = SquaresEnd::kReached;
  double here_ = 0.0;
  double curve_decrement_ = 0.0;
  double length_ = 1.0;
  int refusals_ = 0;
  double highest_ = -kInfinity;
  int lost_ = 0;
  double best_decrement_ = kInfinity;
  int waited_ = 0;
  LinearMixedProfile profile_;  // the last computed one, and its parameters
  VectorXd profile_theta_;
  const Linearization* profiled_ = nullptr;
};

LindstromBatesOutcome LindstromBates::run(LindstromBatesState state, Alternation how) {
  return Run(*this, std::move(state), how).run();
}

}  // namespace silvafit::fit
