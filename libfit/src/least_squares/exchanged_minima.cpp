// SPDX-License-Identifier: MIT
#include "least_squares/exchanged_minima.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/location_coefficients.hpp"
#include "least_squares/periodic_coefficients.hpp"
#include "least_squares/start_search.hpp"

namespace silvafit::fit {
namespace {

Exchange identity(Index size) {
  Exchange result{.factor = VectorXd::Ones(size), .offset = VectorXd::Zero(size)};
  for (Index i = 0; i < size; ++i) result.from.push_back(i);
  return result;
}

/// Differences of a group's coefficients from given ones.
VectorXd group_deviation(const VectorXd& coefficients, const std::vector<Index>& varying) {
  constexpr double kShare = 0.1;
  VectorXd result = VectorXd::Zero(coefficients.size());
  double factor = 1.0;
  for (const Index j : varying) {
    result[j] = kShare * factor * std::max(std::abs(coefficients[j]), kShare);
    factor *= 0.7;  // changes of several coefficients must not cancel
  }
  return result;
}

/// Collects exchanges that lead to the same mean as a minimum, but to other means of the groups.
class SameMean {
 public:
  SameMean(const NonlinearModel& model, const VectorXd& minimum, const std::vector<Index>& varying)
      : model_(model.subset(even_sample(model.response(), kSample))),
        minimum_(minimum),
        deviation_(group_deviation(minimum, varying)),
        mean_(mean(minimum)),
        group_mean_(mean(minimum + deviation_)),
        has_groups_(!varying.empty()) {}

  void consider(const Exchange& exchange) {
    const VectorXd point = exchange.of(minimum_);
    // The minimum itself, or a point with equal values, is not new.
    if ((point - minimum_).cwiseAbs().maxCoeff() <= kRounding * minimum_.cwiseAbs().maxCoeff()) {
      return;
    }
    if (!is_equal(mean(point), mean_)) return;
    if (has_groups_ && is_equal(mean(point + deviation_), group_mean_)) return;
    found_.push_back(exchange);
  }

  std::vector<Exchange> found() && { return std::move(found_); }

 private:
  // Enough rows to distinguish functions.
  static constexpr Index kSample = 50;
  static constexpr double kRounding = 1e-9;

  VectorXd mean(const VectorXd& point) {
    VectorXd result;
    model_.evaluate(point, result, nullptr, workspace_);
    return result;
  }

  static bool is_equal(const VectorXd& a, const VectorXd& b) {
    return (a - b).norm() <= kRounding * b.norm();
  }

  NonlinearModel model_;
  NonlinearModel::Workspace workspace_;
  VectorXd minimum_;
  VectorXd deviation_;
  VectorXd mean_;
  VectorXd group_mean_;
  bool has_groups_;
  std::vector<Exchange> found_;
};

/// Considers all exchanges of up to a number of disjoint pairs of the coefficients from a place on.
void exchange_pairs(
    Exchange& exchange, std::vector<bool>& is_taken, Index from, int pairs, SameMean& same) {
  const auto p = static_cast<Index>(exchange.from.size());
  if (pairs == 0) return;
  for (Index i = from; i < p; ++i) {
    if (is_taken[static_cast<std::size_t>(i)]) continue;
    for (Index j = i + 1; j < p; ++j) {
      if (is_taken[static_cast<std::size_t>(j)]) continue;
      std::swap(exchange.from[static_cast<std::size_t>(i)],
                exchange.from[static_cast<std::size_t>(j)]);
      same.consider(exchange);
      is_taken[static_cast<std::size_t>(j)] = true;
      exchange_pairs(exchange, is_taken, i + 1, pairs - 1, same);
      is_taken[static_cast<std::size_t>(j)] = false;
      std::swap(exchange.from[static_cast<std::size_t>(i)],
                exchange.from[static_cast<std::size_t>(j)]);
    }
  }
}

/// Considers changes of sign of each coefficient.
void negate_each(Exchange exchange, SameMean& same) {
  for (double& factor : exchange.factor) {
    factor = -1.0;
    same.consider(exchange);
    factor = 1.0;
  }
}

/// Considers changes of each share f to 1 - f.
void complement_each(Exchange exchange, SameMean& same) {
  for (Index k = 0; k < exchange.factor.size(); ++k) {
    exchange.factor[k] = -1.0;
    exchange.offset[k] = 1.0;
    same.consider(exchange);
    exchange.factor[k] = 1.0;
    exchange.offset[k] = 0.0;
  }
}

/// Considers shifts of phases by half periods, as far as the argument is zero at an observation.
void shift_phases(const NonlinearModel& model, const VectorXd& minimum, SameMean& same) {
  constexpr double kMost = 24.0;  // half periods around the middle of the observations
  for (const PhaseCoefficient& phase : phase_coefficients(model, minimum)) {
    const double half = 0.5 * phase.period;
    const double middle = 0.5 * (phase.lowest_shift + phase.highest_shift) / half;
    const double first = std::max(phase.lowest_shift / half, middle - 0.5 * kMost);
    const double last = std::min(phase.highest_shift / half, middle + 0.5 * kMost);
    for (double k = std::ceil(first); k <= last; ++k) {
      Exchange exchange = identity(minimum.size());
      exchange.offset[phase.coefficient] = k * half;
      same.consider(exchange);
      negate_each(std::move(exchange), same);
    }
  }
}

/// Shifts of a phase by half periods that leave the mean unchanged, with a change of sign of
/// another coefficient if necessary.
std::vector<Exchange> phase_shifts(const NonlinearModel& model,
                                   const VectorXd& coefficients,
                                   const PhaseCoefficient& phase,
                                   double half_periods) {
  SameMean same(model, coefficients, {});
  Exchange exchange = identity(coefficients.size());
  exchange.offset[phase.coefficient] = 0.5 * half_periods * phase.period;
  same.consider(exchange);
  negate_each(std::move(exchange), same);
  return std::move(same).found();
}

/// The point of a given mean that Gauss and Newton's method reaches; none if it reaches none.
std::optional<VectorXd> point_of_mean(const NonlinearModel& model,
                                      VectorXd point,
                                      const VectorXd& mean) {
  constexpr int kSteps = 20;
  constexpr int kHalvings = 20;
  constexpr double kRounding = 1e-9;
  double distance = (model.mean_at(point) - mean).norm();
  for (int step = 0; step < kSteps && distance > kRounding * mean.norm(); ++step) {
    const auto [here, jacobian] = model.curve_at(point);
    if (!here.allFinite() || !jacobian.allFinite()) return std::nullopt;
    VectorXd change = jacobian.leftCols(point.size()).colPivHouseholderQr().solve(mean - here);
    const double before = distance;
    for (int halving = 0; halving < kHalvings && !(distance < before); ++halving) {
      const double next = (model.mean_at(point + change) - mean).norm();
      if (next < before) {
        point += change;
        distance = next;
      }
      change *= 0.5;
    }
    if (!(distance < before)) return std::nullopt;
  }
  return distance <= kRounding * mean.norm() ? std::optional(point) : std::nullopt;
}

/// Points of the same mean after an exchange of two coefficients to which the others adapt.
std::vector<VectorXd> adapted_exchanges(const NonlinearModel& model, const VectorXd& point) {
  constexpr Index kSample = 50;
  constexpr double kSamePlace = 1e-3;
  const NonlinearModel part = model.subset(even_sample(model.response(), kSample));
  const VectorXd mean = part.mean_at(point);
  std::vector<VectorXd> result;
  for (Index i = 0; i < point.size(); ++i) {
    for (Index j = 0; j < i; ++j) {
      VectorXd start = point;
      std::swap(start[i], start[j]);
      const auto found = point_of_mean(part, std::move(start), mean);
      if (!found) continue;
      const VectorXd change = (*found - point).cwiseAbs();
      if ((change.array() > kSamePlace * point.array().abs()).any()) result.push_back(*found);
    }
  }
  return result;
}

/// The number of exchanges grows fast: with four pairs it is 763 for eight coefficients, with two
/// 675 for ten.
constexpr Index kMostCoefficients = 10;

}  // namespace

VectorXd Exchange::of(const VectorXd& coefficients) const {
  return offset + factor.cwiseProduct(coefficients(from));
}

std::vector<Exchange> exchanges(const NonlinearModel& model,
                                const VectorXd& minimum,
                                const std::vector<Index>& varying) {
  constexpr Index kFewCoefficients = 8;
  const Index p = minimum.size();
  if (p < 2 || p > kMostCoefficients) return {};
  SameMean same(model, minimum, varying);
  Exchange exchange = identity(p);
  std::vector<bool> is_taken(static_cast<std::size_t>(p), false);
  exchange_pairs(exchange, is_taken, 0, p <= kFewCoefficients ? 4 : 2, same);
  for (std::size_t i = 0; i < exchange.from.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::swap(exchange.from[i], exchange.from[j]);
      negate_each(exchange, same);
      complement_each(exchange, same);
      std::swap(exchange.from[i], exchange.from[j]);
    }
  }
  // Without random effects of the period, shifts of a phase give the same fit.
  if (!varying.empty()) shift_phases(model, minimum, same);
  return std::move(same).found();
}

std::vector<VectorXd> exchanged_minima(const NonlinearModel& model, const VectorXd& minimum) {
  std::vector<Index> varying;
  for (const RandomEffects& term : model.specification().random) {
    std::ranges::copy_if(model.coefficients_of(term),
                         std::back_inserter(varying),
                         [&](Index place) { return place < minimum.size(); });
  }
  std::vector<VectorXd> result;
  for (const Exchange& exchange : exchanges(model, minimum, varying)) {
    result.push_back(exchange.of(minimum));
  }
  return result;
}

std::vector<VectorXd> points_of_same_mean(const NonlinearModel& model, const VectorXd& point) {
  std::vector<VectorXd> result;
  if (point.size() > kMostCoefficients) return result;
  for (const Exchange& exchange : exchanges(model, point, {})) result.push_back(exchange.of(point));
  std::ranges::move(adapted_exchanges(model, point), std::back_inserter(result));
  return result;
}

VectorXd nearest_minimum(const NonlinearModel& model,
                         const VectorXd& minimum,
                         const VectorXd& start) {
  VectorXd result = minimum;
  double largest_gain = 0.0;
  for (const Exchange& exchange : exchanges(model, minimum, {})) {
    const VectorXd point = exchange.of(minimum);
    // Coefficients that are exchanged have the same unit.
    const Eigen::ArrayXd unit = start.array().abs().max(start(exchange.from).array().abs());
    const Eigen::ArrayXd gains =
        (minimum - start).array().square() - (point - start).array().square();
    const double gain = (unit > 0.0).select(gains / unit.square(), 0.0).sum();
    if (!(gain > largest_gain)) continue;
    largest_gain = gain;
    result = point;
  }
  return result;
}

VectorXd with_nearest_phases(const NonlinearModel& model,
                             const VectorXd& coefficients,
                             const VectorXd& to) {
  VectorXd result = coefficients;
  for (const PhaseCoefficient& phase : phase_coefficients(model, coefficients)) {
    const double distance = to[phase.coefficient] - result[phase.coefficient];
    const auto shift_to = [&](double half_periods) {
      if (half_periods == 0.0) return true;
      const std::vector<Exchange> found = phase_shifts(model, result, phase, half_periods);
      if (found.empty()) return false;
      result = found.front().of(result);
      return true;
    };
    if (!shift_to(std::round(2.0 * distance / phase.period))) {
      shift_to(2.0 * std::round(distance / phase.period));
    }
  }
  return result;
}

VectorXd with_usual_phases(const NonlinearModel& model, const VectorXd& coefficients) {
  VectorXd result = coefficients;
  for (const PhaseCoefficient& phase : phase_coefficients(model, coefficients)) {
    const double shift = std::clamp(0.0, phase.lowest_shift, phase.highest_shift);
    const double periods = std::round(shift / phase.period);
    if (std::abs(periods) <= 1.0) continue;
    VectorXd shifted = result;
    shifted[phase.coefficient] += periods * phase.period;
    const VectorXd mean = model.mean_at(result);
    // The coefficient may also be outside the sine. The rounding error is that of its large value.
    const double rounding =
        std::max(1e-9, 1e-15 * std::abs(result[phase.coefficient]) / phase.period);
    if ((model.mean_at(shifted) - mean).norm() <= rounding * mean.norm()) {
      result = std::move(shifted);
    }
  }
  return result;
}

VectorXd with_signs_of(const NonlinearModel& model,
                       const VectorXd& coefficients,
                       const VectorXd& to) {
  VectorXd result = coefficients;
  for (const PhaseCoefficient& phase : phase_coefficients(model, coefficients)) {
    for (const Exchange& exchange : phase_shifts(model, result, phase, 1.0)) {
      const Eigen::ArrayXd products = (result.cwiseProduct(to)).array();
      if ((exchange.factor.array() < 0.0 && products < 0.0).any()) {
        result = exchange.of(result);
        break;
      }
    }
  }
  return result;
}

std::vector<VectorXd> exchanged_locations(const NonlinearModel& model, const VectorXd& minimum) {
  constexpr Index kSample = 200;
  constexpr double kSameMinimum = 1e-4;
  constexpr double kSamePlace = 1e-3;
  const std::vector<LocationCoefficient> locations = location_coefficients(model);
  if (locations.size() < 2) return {};
  const NonlinearModel part = model.subset(even_sample(model.response(), kSample));
  ProjectedModel projected(part);
  const auto minimum_from = [&](const VectorXd& point) {
    return descend(
        projected, projected.nonlinear_part(point), {.maximum_iterations = 100, .tolerance = 1e-9});
  };
  const Descent lowest = minimum_from(minimum);
  std::vector<VectorXd> result;
  for (std::size_t i = 0; i < locations.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      VectorXd point = minimum;
      std::swap(point[locations[i].coefficient], point[locations[j].coefficient]);
      const Descent found = minimum_from(point);
      if (!(found.sum_of_squares <= lowest.sum_of_squares * (1.0 + kSameMinimum))) continue;
      const VectorXd change = (found.coefficients - minimum).cwiseAbs();
      if ((change.array() <= kSamePlace * minimum.array().abs()).all()) continue;
      result.push_back(found.coefficients);
    }
  }
  return result;
}

}  // namespace silvafit::fit
