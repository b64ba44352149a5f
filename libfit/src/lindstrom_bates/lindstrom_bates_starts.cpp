// SPDX-License-Identifier: MIT
// Starts of the variance components: those of runs, and others that may lead to a higher maximum.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

QuasiNewtonResult LindstromBates::best_theta(const LindstromBatesState& state,
                                             const QuasiNewtonOptions& options) {
  Linearization at;
  if (!linearize(state, nullptr, at)) return {.x = state.theta, .value = kInfinity};
  const SmoothFunction objective = [&](const VectorXd& theta, VectorXd* by_theta) {
    const LinearMixedProfile value = profile_near(state, at, theta);
    if (!value.is_valid) return kInfinity;
    if (by_theta != nullptr) *by_theta = gradient(theta, value);
    return value.minus_log_likelihood;
  };
  return minimize(objective, state.theta, {}, options);
}

std::vector<LindstromBates::Start> LindstromBates::ends_of(const LindstromBatesState& state,
                                                           const std::vector<Start>& starts) {
  std::vector<Start> ends;
  for (const Start& start : starts) {
    const QuasiNewtonResult end = best_theta(with_theta(state, start.theta), kRoughly);
    if (std::isfinite(end.value) && end.x.allFinite()) ends.push_back({end.x, end.value});
  }
  constexpr std::size_t kMost = 5;
  return lowest(std::move(ends), kMost, 0.0, kVeryStrong);
}

std::vector<LindstromBates::Start> LindstromBates::variance_ends(const LindstromBatesState& state) {
  const Index m = variance_.parameter_count();
  if (m == variance_.correlation_count()) return {};
  std::vector<Start> starts{{.theta = state.theta}};
  for (const VectorXd& other : variance_.starts()) {
    starts.push_back(starts.front());
    starts.back().theta.tail(m) = other;
  }
  // The first one is that of the state, which may know more.
  starts.erase(starts.begin() + 1);
  return ends_of(state, starts);
}

std::vector<LindstromBates::Start> LindstromBates::correlation_starts(
    const LindstromBatesState& state) {
  // Random effects and residuals of a long range explain the same differences of groups: all of
  // these are with the effects, or nearly all with the residuals.
  constexpr std::array kShares{1.0, 0.1};
  std::vector<VectorXd> thetas{state.theta};
  for (Start& end : variance_ends(state)) thetas.push_back(std::move(end.theta));
  std::vector<Start> result;
  for (const VectorXd& start : variance_.correlated()->structure().starts()) {
    for (const VectorXd& from : thetas) {
      for (const double share : kShares) {
        VectorXd theta = from;
        theta.head(random_parameter_count()) *= share;
        theta.tail(start.size()) = start;
        Linearization at;
        if (!theta.allFinite() || !linearize(with_theta(state, theta), nullptr, at)) continue;
        const LinearMixedProfile value = profile_at(at, theta, false);
        if (value.is_valid) result.push_back({theta, value.minus_log_likelihood});
      }
    }
  }
  return result;
}

std::vector<LindstromBates::Start> LindstromBates::lowest(std::vector<Start> starts,
                                                          std::size_t most,
                                                          double apart,
                                                          double higher) const {
  std::ranges::stable_sort(starts, {}, &Start::value);
  const Index last = random_parameter_count() + variance_.parameter_count();
  const Index range = std::min(last - 1, last - variance_.correlation_count());
  std::vector<Start> result;
  for (Start& start : starts) {
    if (result.size() == most || start.value > starts.front().value + higher) break;
    const bool is_new = std::ranges::none_of(result, [&](const Start& other) {
      return std::abs(start.theta[range] - other.theta[range]) < apart ||
             std::abs(start.value - other.value) < kSameLikelihood;
    });
    if (is_new) result.push_back(start);
  }
  return result;
}

std::vector<LindstromBatesState> LindstromBates::with_residuals(const LindstromBatesState& state) {
  // At most so many descents, from ranges that differ by half or more.
  constexpr std::size_t kDescents = 10;
  constexpr double kHalf = 0.6;
  std::vector<Start> ends;
  if (variance_.correlated() != nullptr) {
    ends = ends_of(state, lowest(correlation_starts(state), kDescents, kHalf, kInfinity));
  } else if (variance_.starts().size() > 1) {
    ends = variance_ends(state);
  }
  std::vector<LindstromBatesState> result;
  for (const Start& end : ends) result.push_back(with_theta(state, end.theta));
  if (result.empty()) result.push_back(state);
  return result;
}

QuasiNewtonResult LindstromBates::settle(LindstromBatesState& state) {
  // The series of the weights is accurate only near its center, which is therefore moved.
  constexpr int kMoves = 5;
  constexpr double kNear = 0.1;
  QuasiNewtonResult best;
  for (int move = 0; move < kMoves; ++move) {
    const QuasiNewtonResult next = best_theta(state, {.maximum_steps = kThetaSteps});
    if (!std::isfinite(next.value) || !next.x.allFinite()) break;
    best = next;
    const VectorXd change = variance_parameters(best.x) - variance_parameters(state.theta);
    state = with_theta(state, best.x);
    if (change.size() == 0 || change.cwiseAbs().maxCoeff() < kNear) break;
  }
  return best;
}

LindstromBatesState LindstromBates::first_order_start() {
  LindstromBatesState state = start(1.0);
  settle(state);
  return state;
}

std::vector<VectorXd> LindstromBates::distant_thetas(const LindstromBatesOutcome& outcome) const {
  const VectorXd& now = outcome.state.theta;
  std::vector<VectorXd> result;
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    // Without effects the likelihood may have a maximum below that with them.
    constexpr double kSmall = 1e-2;
    const VectorXd usual = VectorXd::Constant(factor.size(), typical_deviation(t));
    const MatrixXd here = factor.factor(now.segment(begin, factor.parameter_count()));
    if ((here.rowwise().norm().array() < kSmall * typical_deviation(t)).any()) {
      result.push_back(now);
      result.back().segment(begin, factor.parameter_count()) = factor.from_diagonal(usual);
    }
    if (!model_.specification().random[t].has_equal_variances()) return;
    // Columns of unlike sizes share a variance, which may be that of any of them.
    const VectorXd units = scale_(random_[t]);
    for (Index k = 0; factor.size() > 1 && k < factor.size(); ++k) {
      const MatrixXd own =
          typical_deviation(t) * units[k] * MatrixXd::Identity(factor.size(), factor.size());
      result.push_back(now);
      result.back().segment(begin, factor.parameter_count()) =
          factor.from_factor(scaled_values(random_[t], own));
    }
  });
  // The residuals of different groups, or another part of them, may follow the variance function:
  // log g changes by a standard deviation of 1.6.
  constexpr double kFar = 4.0;
  const Index first = random_parameter_count();
  for (const VarianceModel::Quantity& quantity : variance_.quantities()) {
    if (quantity.kind != VarianceQuantity::kDelta) continue;
    for (const double side : {-kFar, kFar}) {
      result.push_back(now);
      result.back().segment(first + quantity.first, quantity.count) +=
          side * outcome.at->longest_change.segment(quantity.first, quantity.count);
    }
  }
  return result;
}

std::vector<LindstromBatesState> LindstromBates::other_maxima(
    const LindstromBatesOutcome& outcome) {
  // Correlated residuals have starts of their own.
  if (!outcome.converged || variance_.correlated() != nullptr) return {};
  adopt_units(outcome.state.scale, outcome.state.mixing);
  std::vector<LindstromBatesState> higher;
  for (const VectorXd& theta : distant_thetas(outcome)) {
    LindstromBatesState state = with_theta(outcome.state, theta);
    const QuasiNewtonResult end = settle(state);
    if (end.x.size() > 0 && end.value < -outcome.log_likelihood - kHigher) {
      higher.push_back(std::move(state));
    }
  }
  return higher;
}

}  // namespace silvafit::fit
