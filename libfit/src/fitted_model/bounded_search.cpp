// SPDX-License-Identifier: MIT
#include "fitted_model/bounded_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace silvafit::fit {
namespace {

/// Log-likelihoods that differ by less are the same.
constexpr double kSame = 1e-8;
/// A fit that did not converge is better where its log-likelihood is higher by more than this, which
/// no rounding makes.
constexpr double kClearly = 1e-4;
/// Sets of held coefficients that are tried at most: all of four coefficients, of more the most
/// promising.
constexpr std::size_t kMostSets = 80;

double estimate_of(const FittedModel& fit, const std::string& name) {
  return fit.estimate[std::ranges::find(fit.coefficient_names, name) -
                      fit.coefficient_names.begin()];
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

/// "a = 60, its upper bound; c = 1, its lower bound".
std::vector<std::string> in_words(const HeldValues& held,
                                  const std::map<std::string, Bounds>& bounds) {
  std::vector<std::string> result;
  for (const auto& [name, value] : held) {
    const bool is_upper = value == bounds.at(name).high;
    result.push_back(fmt::format(
        "{} = {}, its {} bound", name, data::shortest(value), is_upper ? "upper" : "lower"));
  }
  return result;
}

}  // namespace

FitResult BoundedSearch::run() {
  open({}, std::numeric_limits<double>::infinity());
  while (!open_.empty() && outcomes_.size() < kMostSets) {
    const Branch branch = take_most_promising();
    if (!can_be_better(branch.limit)) break;
    Candidate found = candidate(branch.held, nullptr);
    outcomes_[branch.held] = {found.converged(), found.point.value, found.rising};
    // A fit that did not converge sets no limit to others but the one that it had itself.
    branch_from(found, found.converged() ? found.point.value : branch.limit);
    keep(std::move(found));
  }
  search_between();
  return conclusion();
}

BoundedSearch::Candidate BoundedSearch::candidate(const HeldValues& held,
                                                  const FittedModel* nearby) const {
  Candidate result{.result = fit_(held, nearby), .held = held};
  const FittedModel& fit = result.result.fit;
  for (const auto& [name, range] : bounds_) {
    const double value = estimate_of(fit, name);
    if (!held.contains(name) && (is_outside(range, value) || std::isnan(value))) {
      result.crossed.push_back(name);
    }
  }
  result.point.value = fit.log_likelihood;
  if (!result.converged()) return result;
  result.point = slopes_of_(fit, held);
  for (const auto& [name, slope] : result.point.slopes) {
    if (rises_inwards(name, slope, held.at(name))) result.rising.push_back(name);
  }
  return result;
}

/// A slope that is not known is none that is right.
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
  // What is free there is held by the sets that led here, perhaps in vain.
  for (const std::string& name : at.rising) {
    open(without(at.held, name), std::numeric_limits<double>::infinity());
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
  return !best_ || !(limit <= best_->point.value + kSame);
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
  } else if (is_above(unfinished_)) {
    unfinished_ = std::move(candidate);
  }
}

/// From this end of the range the likelihood rises inwards: there is a maximum inside if it does so
/// from the other end too, or is lower there. An end at infinity or without a fit may be such a one.
bool BoundedSearch::may_turn_inside(const Candidate& end, const std::string& name) const {
  if (best_ && end.point.value > best_->point.value + kSame) return true;
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

void BoundedSearch::search_between() {
  std::vector<Candidate> ends = std::exchange(ends_, {});
  std::ranges::stable_sort(ends, std::ranges::greater{}, [](const Candidate& candidate) { return candidate.point.value; });
  for (const Candidate& end : ends) {
    for (const std::string& name : end.rising) {
      if (may_turn_inside(end, name)) search_inside(end, name);
    }
  }
  ends_ = std::move(ends);
}

/// Between a point from which the likelihood rises and one towards which it does not, each half is
/// told by the slope of the profile in the middle; from each point nearer a fit is tried.
void BoundedSearch::search_inside(const Candidate& end, const std::string& name) {
  constexpr int kHalvings = 12;
  const HeldValues others = without(end.held, name);
  const Bounds& range = bounds_.at(name);
  const bool is_from_low = end.held.at(name) == range.low;
  double near = end.held.at(name);
  double far = is_from_low ? range.high : range.low;
  double stride = (is_from_low ? 1.0 : -1.0) * std::max(std::abs(near), 1.0);
  FittedModel from = end.result.fit;
  for (int halving = 0; halving < kHalvings; ++halving) {
    Candidate released = candidate(others, &from);
    if (released.is_optimal()) {
      keep(std::move(released));
      return;
    }
    const double middle = std::isfinite(far) ? near + 0.5 * (far - near) : near + stride;
    stride *= 2.0;
    const Candidate at = candidate(with(others, name, middle), &from);
    const bool rises_on =
        at.converged() && (at.point.slopes.at(name) > 0.0) == is_from_low;
    (rises_on ? near : far) = middle;
    if (at.converged()) from = at.result.fit;
  }
}

FitResult BoundedSearch::conclusion() {
  if (best_ && unfinished_ && unfinished_->point.value > best_->point.value + kClearly) {
    best_.reset();
  }
  if (best_) {
    FittedModel& fit = best_->result.fit;
    const std::vector<std::string> words = in_words(best_->held, bounds_);
    if (words.empty()) return std::move(best_->result);
    fit.convergence.verdict += fmt::format(
        " Held at a bound, from which the likelihood falls inwards: {}.", fmt::join(words, "; "));
    if (fit.parameter_count > 0) fit.parameter_count += static_cast<int>(words.size());
    auto& boundary = fit.convergence.boundary;
    boundary.insert(boundary.end(), words.begin(), words.end());
    return std::move(best_->result);
  }
  if (unfinished_) {
    FittedModel& fit = unfinished_->result.fit;
    const std::vector<std::string> words = in_words(unfinished_->held, bounds_);
    if (!words.empty()) {
      fit.convergence.verdict += fmt::format(" Held at a bound: {}.", fmt::join(words, "; "));
    }
    return std::move(unfinished_->result);
  }
  if (!ends_.empty()) {
    Candidate& end = *std::ranges::max_element(
        ends_, {}, [](const Candidate& candidate) { return candidate.point.value; });
    Convergence& convergence = end.result.fit.convergence;
    convergence.converged = false;
    convergence.verdict = fmt::format(
        "Not converged: with {} the likelihood rises into the range of {}, but no maximum was found "
        "there: give start values or narrower bounds.",
        fmt::join(in_words(end.held, bounds_), " and "),
        fmt::join(end.rising, " and "));
    return std::move(end.result);
  }
  Convergence& convergence = first_->result.fit.convergence;
  const bool was_converged = std::exchange(convergence.converged, false);
  convergence.verdict = fmt::format(
      "Not converged: no fit within the bounds was found. The one without them, which is shown, lies "
      "outside{}",
      was_converged ? "." : ". " + convergence.verdict);
  return std::move(first_->result);
}

}  // namespace silvafit::fit
