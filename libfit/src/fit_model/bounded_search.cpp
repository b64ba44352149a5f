// SPDX-License-Identifier: MIT
#include "fit_model/bounded_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "optimization/tolerances.hpp"
#include "optimum_search/chosen_optimum.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

constexpr double kNone = -kInfinity;
/// Maximum number of sets of held coefficients: all 3^4 of four coefficients, of more the most
/// promising.
constexpr std::size_t kMostSets = 81;

double estimate_of(const FittedModel& fit, const std::string& name) {
  return fit
      .estimate[std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin()];
}

bool is_outside(const Bounds& range, double value) {
  return value < range.low || value > range.high;
}

HeldValues with(HeldValues held, const std::string& name, double value) {
  held[name] = value;
  return held;
}

HeldValues without(HeldValues held, const std::string& name) {
  held.erase(name);
  return held;
}

}  // namespace

FitResult BoundedSearch::run() {
  open({}, kInfinity);
  while (!open_.empty() && outcomes_.size() < kMostSets) {
    const Branch branch = take_most_promising();
    if (!can_be_better(branch.limit)) break;
    Candidate found = candidate(branch.held, nullptr);
    outcomes_[branch.held] = {found.converged(), found.point.value, found.rising};
    // A fit at a lower one of several maxima gives no limit for other sets.
    const Outcome& free = outcomes_.begin()->second;  // the empty set is the first
    const double limit = free.converged ? std::min(free.value, branch.limit) : branch.limit;
    if (found.converged() && found.point.value > limit + kRoundedLikelihood) limits_hold_ = false;
    const bool is_limit = found.converged() && !branch.held.empty();
    if (!found.is_inside() && inside_ && (found.converged() || branch.held.empty())) {
      if (auto inside = inside_(found.result.fit, branch.held)) {
        keep(candidate(branch.held, *std::move(inside)));
      }
    }
    branch_from(found, is_limit ? found.point.value : branch.limit);
    keep(std::move(found));
  }
  search_between();
  search_outwards();
  return conclusion();
}

BoundedSearch::Candidate BoundedSearch::candidate(const HeldValues& held, FitResult found) const {
  Candidate result{.result = std::move(found), .held = held};
  const FittedModel& fit = result.result.fit;
  for (const auto& [name, range] : bounds_) {
    const double value = estimate_of(fit, name);
    if (!held.contains(name) && (is_outside(range, value) || std::isnan(value))) {
      result.crossed.push_back(name);
    }
  }
  const bool is_known = std::isfinite(fit.log_likelihood) && fit.sigma > 0.0;
  // Restricted likelihoods of fits with other coefficients cannot be compared.
  const bool is_restricted = fit.reml && is_known && !result.converged();
  result.point.value = is_restricted ? slopes_of_(fit, held).value : fit.log_likelihood;
  if (std::isnan(result.point.value)) result.point.value = kNone;
  if (!result.converged()) return result;
  result.point = slopes_of_(fit, held);
  for (const auto& [name, slope] : result.point.slopes) {
    if (rises_inwards(name, slope, held.at(name))) result.rising.push_back(name);
  }
  return result;
}

/// An unknown slope is treated as one that increases inwards.
bool BoundedSearch::rises_inwards(const std::string& name, double slope, double at) const {
  if (!is_slope(slope)) return false;
  if (std::isnan(slope)) return true;
  return at == bounds_.at(name).low ? slope > 0.0 : slope < 0.0;
}

void BoundedSearch::branch_from(const Candidate& at, double limit) {
  std::vector<std::string> names = at.crossed;
  if (names.empty() && !at.converged()) {
    for (const auto& [name, range] : bounds_) {
      if (!at.held.contains(name)) names.push_back(name);
    }
  }
  for (const std::string& name : names) {
    const Bounds& range = bounds_.at(name);
    for (const double bound : {range.low, range.high}) {
      if (std::isfinite(bound)) open(with(at.held, name, bound), limit);
    }
  }
  // The parent sets may hold coefficients that should be free.
  for (const std::string& name : at.rising) {
    open(without(at.held, name), kInfinity);
  }
}

void BoundedSearch::open(const HeldValues& held, double limit) {
  if (known_.insert(held).second) open_.push_back({held, limit});
}

BoundedSearch::Branch BoundedSearch::take_most_promising() {
  const auto chosen = std::ranges::min_element(open_, [](const Branch& a, const Branch& b) {
    return a.limit != b.limit ? a.limit > b.limit : a.held.size() < b.held.size();
  });
  Branch result = std::move(*chosen);
  open_.erase(chosen);
  return result;
}

bool BoundedSearch::can_be_better(double limit) const {
  return !best_ || !limits_hold_ || !(limit <= best_->point.value + kRoundedLikelihood);
}

void BoundedSearch::keep(Candidate candidate) {
  const auto is_above = [&](const std::optional<Candidate>& other) {
    return !other || candidate.point.value > other->point.value;
  };
  if (candidate.is_optimal()) {
    if (is_above(best_)) best_ = std::move(candidate);
    return;
  }
  if (!candidate.is_inside()) {
    if (!first_) first_ = std::move(candidate);
  } else if (candidate.converged()) {
    ends_.push_back(std::move(candidate));
  } else if (is_above(unfinished_) && (candidate.point.value > kNone || !first_)) {
    // A fit outside the bounds gives more information than a set without a value of the formula.
    unfinished_ = std::move(candidate);
  }
}

/// Fits from each end from which the likelihood increases, and a longer search if there must be a
/// maximum between.
void BoundedSearch::search_between() {
  std::vector<Candidate> ends = std::exchange(ends_, {});
  std::ranges::stable_sort(ends, std::ranges::greater{}, value_of);
  for (const Candidate& end : ends) {
    for (const std::string& name : end.rising) {
      if (release(end.result.fit, without(end.held, name))) continue;
      if (has_maximum_between(end, name)) halve(end, name);
    }
  }
  for (Candidate& end : ends) {
    std::erase_if(end.rising, [&](const std::string& name) { return !rises_by_values(end, name); });
    keep(std::move(end));
  }
}

/// Whether fits held further inside are better than an end. A slope may be infinite, as that of a
/// root at 0, and that of lb is of the model linear around the estimates, which moves with them.
/// The nearest fit whose likelihood differs decides; it may be at any distance.
bool BoundedSearch::rises_by_values(const Candidate& end, const std::string& name) const {
  constexpr double kNearest = 1e-12;
  constexpr double kFurther = 100.0;
  const double at = end.held.at(name);
  const Bounds& range = bounds_.at(name);
  const double width = range.high - range.low;
  const double farthest = std::isfinite(width) ? 0.1 * width : std::max(std::abs(at), 1.0);
  const double sign = at == range.low ? 1.0 : -1.0;
  for (double share = kNearest; share <= 1.0; share *= kFurther) {
    const double inside = at + sign * share * farthest;
    const Candidate next = candidate(with(end.held, name, inside), &end.result.fit);
    if (!next.converged()) continue;
    const double gain = next.point.value - end.point.value;
    if (std::abs(gain) > kSameLikelihood) return gain > 0.0;
  }
  return true;
}

bool BoundedSearch::release(const FittedModel& from, const HeldValues& held) {
  Candidate released = candidate(held, &from);
  const bool is_found = released.is_optimal();
  if (is_found) keep(std::move(released));
  return is_found;
}

/// The likelihood increases from this end into the range. There is a maximum inside if it also
/// increases from the other end, or is lower there. This may also hold if the other end is infinite
/// or has no fit.
bool BoundedSearch::has_maximum_between(const Candidate& end, const std::string& name) const {
  if (best_ && end.point.value > best_->point.value + kRoundedLikelihood) return true;
  const auto inner = outcomes_.find(without(end.held, name));
  if (inner != outcomes_.end() && inner->second.converged) {
    if (!can_be_better(inner->second.value)) return false;
  }
  const Bounds& range = bounds_.at(name);
  const double other = end.held.at(name) == range.low ? range.high : range.low;
  if (!std::isfinite(other)) return true;
  const auto across = outcomes_.find(with(end.held, name, other));
  if (across == outcomes_.end()) return false;
  return !across->second.converged ||
         std::ranges::find(across->second.rising, name) != across->second.rising.end();
}

/// Bisection by the slope of the profile, between a point from which the likelihood increases and
/// one towards which it does not; a fit starts from each nearer point.
void BoundedSearch::halve(const Candidate& end, const std::string& name) {
  constexpr int kHalvings = 12;
  const HeldValues others = without(end.held, name);
  const Bounds& range = bounds_.at(name);
  const bool is_from_low = end.held.at(name) == range.low;
  double near = end.held.at(name);
  double far = is_from_low ? range.high : range.low;
  double stride = (is_from_low ? 1.0 : -1.0) * std::max(std::abs(near), 1.0);
  FittedModel from = end.result.fit;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = std::isfinite(far) ? near + 0.5 * (far - near) : near + stride;
    stride *= 2.0;
    Candidate at = candidate(with(others, name, middle), &from);
    const bool rises_on = at.converged() && (at.point.slopes.at(name) > 0.0) == is_from_low;
    (rises_on ? near : far) = middle;
    if (!at.converged()) continue;
    from = std::move(at.result.fit);
    if (release(from, others)) return;
  }
}

/// Towards an infinite end of a range the likelihood may be higher than at the best point: there is
/// another maximum, or the curve has a limit. The fit without bounds, which is outside, does not
/// show it.
void BoundedSearch::search_outwards() {
  constexpr double kFar = 1e3;  // as mark_limit() looks
  if (!best_ || !first_) return;
  for (const auto& [name, range] : bounds_) {
    const double size = std::max(std::abs(estimate_of(best_->result.fit, name)),
                                 std::abs(estimate_of(first_->result.fit, name)));
    for (const double end : {range.low, range.high}) {
      if (std::isfinite(end)) continue;
      const HeldValues others = without(best_->held, name);
      const Candidate far = candidate(with(others, name, std::copysign(kFar * size, end)), nullptr);
      const auto is_higher = [&] { return value_of(far) > value_of(*best_) + kSameLikelihood; };
      if (!far.converged() || !far.is_inside() || !is_higher()) continue;
      release(far.result.fit, others);
      if (is_higher()) unbounded_.push_back(name);
    }
  }
}

double BoundedSearch::value_of(const Candidate& candidate) { return candidate.point.value; }

std::vector<Evidence> BoundedSearch::at_bounds(const HeldValues& held) const {
  std::vector<Evidence> result;
  for (const auto& [name, value] : held) {
    const bool is_upper = value == bounds_.at(name).high;
    result.push_back({.kind = is_upper ? Evidence::Kind::kUpperBound : Evidence::Kind::kLowerBound,
                      .term = name,
                      .value = value});
  }
  return result;
}

namespace {

std::vector<std::string> in_words(const std::vector<Evidence>& bounds) {
  std::vector<std::string> words;
  words.reserve(bounds.size());
  for (const Evidence& bound : bounds) words.push_back(text_of(bound));
  return words;
}

}  // namespace

FitResult BoundedSearch::on_bounds(Candidate candidate) const {
  FittedModel& fit = candidate.result.fit;
  const std::vector<Evidence> bounds = at_bounds(candidate.held);
  if (bounds.empty()) return std::move(candidate.result);
  fit.convergence.find({.kind = Finding::Kind::kAtBounds, .names = in_words(bounds)});
  if (fit.parameter_count > 0) fit.parameter_count += static_cast<int>(bounds.size());
  for (const Evidence& bound : bounds) fit.convergence.add_boundary(bound);
  return std::move(candidate.result);
}

FitResult BoundedSearch::unfinished(Candidate candidate) const {
  const std::vector<Evidence> bounds = at_bounds(candidate.held);
  if (!bounds.empty()) {
    candidate.result.fit.convergence.find(
        {.kind = Finding::Kind::kEndsAtBounds, .names = in_words(bounds)});
  }
  return std::move(candidate.result);
}

FitResult BoundedSearch::rising_inwards(Candidate candidate) const {
  candidate.result.fit.convergence.conclude(
      ConvergenceStatus::kMaximumNotReached,
      {.kind = Finding::Kind::kRisesInwards,
       .names = {fmt::format("{}", fmt::join(candidate.rising, " and ")),
                 fmt::format("{}", fmt::join(in_words(at_bounds(candidate.held)), " and "))}});
  return std::move(candidate.result);
}

FitResult BoundedSearch::outside(Candidate candidate) const {
  Convergence& convergence = candidate.result.fit.convergence;
  if (convergence.converged()) convergence.findings.clear();
  convergence.status = ConvergenceStatus::kOutsideBounds;
  convergence.find({.kind = Finding::Kind::kNoneInside});
  return std::move(candidate.result);
}

FitResult BoundedSearch::without_maximum(Candidate candidate) const {
  FittedModel& fit = candidate.result.fit;
  fit.convergence.conclude(ConvergenceStatus::kNoMaximum,
                           {.kind = Finding::Kind::kLimitOfCurve, .names = unbounded_},
                           Evidence::Kind::kUnbounded);
  fit.covariance.setConstant(kNaN);
  return std::move(candidate.result);
}

/// The best result. It has not converged if something better is within the bounds.
FitResult BoundedSearch::conclusion() {
  if (!unbounded_.empty()) return without_maximum(std::move(*best_));
  const auto end = std::ranges::max_element(ends_, {}, value_of);
  const double end_value = end == ends_.end() ? kNone : value_of(*end);
  const double unfinished_value = unfinished_ ? value_of(*unfinished_) : kNone;
  if (best_ && std::max(end_value, unfinished_value) <= value_of(*best_) + kSameLikelihood) {
    return on_bounds(std::move(*best_));
  }
  if (unfinished_ && (end == ends_.end() || unfinished_value >= end_value)) {
    return unfinished(std::move(*unfinished_));
  }
  if (end != ends_.end()) return rising_inwards(std::move(*end));
  return outside(std::move(*first_));
}

}  // namespace silvafit::fit
