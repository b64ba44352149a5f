// SPDX-License-Identifier: MIT
#include "optimum_search/local_optima.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "model/symmetric_eigen.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {

namespace {

constexpr std::string_view kMaximumOrigin = "maximum of the marginal likelihood";
constexpr Method kFirst = Method::kInteraction;
constexpr double kNone = -kInfinity;

/// Coefficients with fixed effects of a group that is drawn from the distribution of a fit's random
/// effects.
VectorXd drawn_group(const NonlinearModel& model,
                     const MixedEffectsFit& fit,
                     std::uint64_t number) {
  constexpr std::uint64_t kSeed = 2;
  Random random(kSeed, number);
  VectorXd result = model.extended(fit.estimate);
  const std::vector<RandomEffects>& terms = model.specification().random;
  for (std::size_t term = 0; term < terms.size(); ++term) {
    const std::vector<Index> places = model.coefficients_of(terms[term]);
    const SymmetricEigen of = symmetric_eigen(fit.random[term].covariance);
    VectorXd draw(of.values.size());
    for (double& value : draw) value = random.normal();
    const VectorXd sizes = of.values.cwiseMax(0.0).cwiseSqrt();
    const VectorXd change = of.vectors * sizes.cwiseProduct(draw);
    for (Index k = 0; k < change.size(); ++k) {
      result[places[static_cast<std::size_t>(k)]] += change[k];
    }
  }
  return result.head(fit.estimate.size());
}

}  // namespace

LocalOptima::LocalOptima(const NonlinearModel& model,
                         const MixedEffectsOptions& options,
                         std::vector<StartingPoint> starts)
    : model_(model), options_(options), starts_(std::move(starts)), budget_(model, kOperations) {
  options_.starts.clear();
}

void LocalOptima::search(bool is_result) {
  descend();
  budget_ = SearchBudget(model_, kOperations);
  const bool has_effects = !model_.specification().random.empty();
  if (has_effects && (is_result || has_several())) climb();
  if (!has_high_end()) climb_exactly();
  if (!has_converged(ends_)) search_longer();
  try_other_variances();
  if (!has_effects) return;
  if (is_result || has_several()) {
    compare_with_smaller();
    climb();
    if (is_result) explore();
  } else {
    compare_with_none();
  }
}

/// Runs from other variance components at the best end.
void LocalOptima::try_other_variances() {
  if (!has_converged(ends_)) return;
  const MixedEffectsFit best = best_of(ends_).fit;
  for (MixedEffectsFit& end : higher_maxima(model_, best, options_)) {
    add_end(std::move(end), "other variance components");
  }
}

/// Whether a fixed point is about as high as the highest maximum.
bool LocalOptima::has_high_end() const {
  return has_converged(ends_) && !(highest_converged(maxima_) > best_of(ends_).rank + kDoubtful);
}

/// Where no fixed point was reached from the highest maxima of the first-order likelihood, one may
/// be reached from those of Laplace's.
void LocalOptima::climb_exactly() {
  std::vector<MixedEffectsFit> starts;
  for (const Candidate* const maximum : spread_out(maxima_, kClimbs)) {
    if (starts.size() < kClimbs) starts.push_back(maximum->fit);
  }
  for (const MixedEffectsFit& start : starts) {
    const MarginalEnd end = marginal_from(model_, start, Method::kLaplace, options_);
    budget_.spend_evaluations(end.evaluations);
    if (!end.fit || !end.fit->convergence.converged()) continue;
    if (auto found = fixed_point_from(model_, *end.fit)) {
      add_end(*std::move(found), std::string(kMaximumOrigin));
    }
  }
}

/// Further starts if several fixed points are similarly high, as there may then be many more:
/// coefficients of groups, drawn from the distribution of the best fit; again after a better fit
/// was found.
void LocalOptima::explore() {
  constexpr std::uint64_t kDrawn = 8;
  for (std::uint64_t round = 0; round < kRounds; ++round) {
    if (ends_.empty()) return;
    const Candidate best = best_of(ends_);
    const auto similar = std::ranges::count_if(ends_, [&](const Candidate& end) {
      return end.fit.convergence.converged() && end.rank > best.rank - 2.0 * kVeryStrong;
    });
    if (similar < 2) return;
    for (std::uint64_t k = 0; k < kDrawn && !budget_.is_spent(); ++k) {
      run_from({.coefficients = drawn_group(model_, best.fit, round * kDrawn + k),
                .origin = "a drawn group"});
    }
    if (!(best_of(ends_).rank > best.rank + kHigher)) return;
  }
}

/// From the first start, with all starts of the variance components.
void LocalOptima::search_longer() {
  LindstromBatesSearch found = climb_lindstrom_bates(
      model_, starts_.front().coefficients, options_, Persistence::kUntilFound);
  budget_.spend_work(found.work);
  if (!found.outcome.is_valid) return;
  add_end(found.engine->result(found.outcome), starts_.front().origin, found.outcome.obstacle);
}

/// Runs Lindstrom and Bates' method from each start.
void LocalOptima::descend() {
  for (std::size_t k = 0; k < starts_.size(); ++k) {
    const StartingPoint& start = starts_[k];
    // The first start and those that the user asked for are tried at any cost.
    const bool is_asked = k == 0 || start.origin == kStartValues || start.origin == kSpreadStart;
    if (!is_asked && budget_.is_spent() && has_converged(ends_)) continue;
    const bool is_reached = std::isfinite(run_from(start));
    if (start.with_effects) {
      auto found = fixed_point_from(model_, *start.with_effects);
      if (found) add_end(*std::move(found), start.origin);
    }
    if (start.origin == kStartValues) {
      // With narrow random effects the run stays near its starting coefficients.
      for (const double spread : {0.1, 0.01}) run_from(start, spread);
    }
    const bool is_minimum = start.origin == kPooledFit || start.origin == kOtherMinimum;
    if (!is_reached && is_minimum) failed_.push_back(start.coefficients);
  }
}

double LocalOptima::run_from(const StartingPoint& point, double spread) {
  LindstromBatesSearch found =
      climb_lindstrom_bates(model_, point.coefficients, options_, Persistence::kOnce, spread);
  // The user's further starts are additional to all others.
  if (point.origin != kSpreadStart) budget_.spend_work(found.work);
  if (!found.outcome.is_valid) return kNone;
  return add_end(found.engine->result(found.outcome), point.origin, found.outcome.obstacle);
}

std::optional<MixedEffectsFit> LocalOptima::fixed_point_from(const NonlinearModel& model,
                                                             const MixedEffectsFit& start) {
  LindstromBatesEnd end = lindstrom_bates_from(model, start, options_);
  budget_.spend_work(end.work);
  return std::move(end.fit);
}

double LocalOptima::add_end(MixedEffectsFit fit, const std::string& origin, Obstacle obstacle) {
  const double rank = model_.specification().random.empty()
                          ? fit.log_likelihood
                          : marginal_log_likelihood(model_, fit, kFirst, options_);
  budget_.spend_evaluations(1);
  const bool is_reached = fit.convergence.converged();
  add_candidate(
      ends_,
      {.fit = std::move(fit), .origin = origin, .obstacle = std::move(obstacle), .rank = rank});
  return is_reached ? rank : kNone;
}

/// Searches the maxima of the first-order likelihood near the best ends, and runs from there.
void LocalOptima::climb() {
  // The linearization of a linear model is exact.
  if (model_.is_linear()) return;
  for (int round = 0; round < kRounds && !budget_.is_spent() && !ends_.empty(); ++round) {
    const std::size_t known = ends_.size();
    const Candidate best = best_of(ends_);
    std::vector<MixedEffectsFit> starts;
    for (const Candidate* const end : spread_out(ends_, kClimbs - 1)) {
      if (starts.size() == kClimbs) break;
      if (!end->is_followed && !is_far_below(end->rank, best)) starts.push_back(end->fit);
    }
    for (Candidate& end : ends_) {
      end.is_followed = end.is_followed || std::ranges::any_of(starts, [&](const auto& start) {
                          return is_same(end.fit, start);
                        });
    }
    for (const MixedEffectsFit& start : starts) {
      if (!budget_.is_spent() && !is_complete()) climb_from(start);
    }
    if (round == 0) climb_from_failed();
    if (ends_.size() == known) return;
  }
}

/// Whether further searches of maxima are useless: w maxima were found by n searches, and the
/// regions of unknown ones have an expected share of w (w + 1) / (n (n - 1)) of all starts.
/// Source: Boender and Rinnooy Kan 1987, Mathematical Programming 37: 59-80.
bool LocalOptima::is_complete() const {
  const auto w = static_cast<double>(std::ranges::count_if(
      maxima_, [](const Candidate& maximum) { return maximum.fit.convergence.converged(); }));
  const auto n = static_cast<double>(climbs_);
  return w > 0.0 && n > 1.0 && w * (w + 1.0) < kUnseen * n * (n - 1.0);
}

/// A failed run from a pooled minimum ends anywhere; the search of a maximum begins at the minimum
/// itself.
void LocalOptima::climb_from_failed() {
  for (const VectorXd& start : failed_) {
    const bool is_known = std::ranges::any_of(ends_, [&](const Candidate& end) {
      return end.fit.convergence.converged() && is_in_region(end.fit.estimate, start);
    });
    if (is_known || budget_.is_spent() || is_complete()) continue;
    add_maximum(marginal_from_coefficients(
        model_, start, kFirst, options_, {.known = highest_converged(maxima_)}));
  }
}

void LocalOptima::climb_from(const MixedEffectsFit& start) {
  add_maximum(
      marginal_from(model_, start, kFirst, options_, {.known = highest_converged(maxima_)}));
}

/// Notes a maximum; a new one is a start.
void LocalOptima::add_maximum(MarginalEnd end) {
  ++climbs_;
  budget_.spend_evaluations(end.evaluations);
  // A search that has been stopped goes on as long as it makes progress.
  while (end.fit && !end.fit->convergence.converged() && !budget_.is_spent()) {
    const double before = end.fit->log_likelihood;
    MarginalEnd next =
        marginal_from(model_, *end.fit, kFirst, options_, {.known = highest_converged(maxima_)});
    budget_.spend_evaluations(next.evaluations);
    if (!next.fit || !(next.fit->log_likelihood > before + kHigher)) break;
    end = std::move(next);
  }
  if (!end.fit || !std::isfinite(end.fit->log_likelihood)) return;
  const MixedEffectsFit maximum = *std::move(end.fit);
  if (!add_candidate(maxima_,
                     {.fit = maximum,
                      .origin = std::string(kMaximumOrigin),
                      .obstacle = std::move(end.obstacle),
                      .rank = maximum.log_likelihood})) {
    return;
  }
  // The fixed point near a maximum is lower than that.
  if (has_converged(ends_) && maximum.log_likelihood < best_of(ends_).rank) return;
  const StartingPoint point{.coefficients = maximum.estimate,
                            .origin = std::string(kMaximumOrigin)};
  const auto found = fixed_point_from(model_, maximum);
  const bool is_near = found && add_end(*found, point.origin) > maximum.log_likelihood - kDoubtful;
  if (is_near && !has_several()) return;
  // With narrow random effects the method stays near the coefficients; with wide ones it may find
  // another fixed point.
  for (const double spread : {0.01, 1.0}) run_from(point, spread);
}

/// Runs from the fits of smaller random structures that are higher.
void LocalOptima::compare_with_smaller() {
  compare_with_none();
  for (const SmallerStructure& smaller : smaller_structures(model_)) {
    if (budget_.is_spent() || ends_.empty()) return;
    compare_with(smaller);
  }
}

/// A maximum of the likelihood without random effects may be one of the mixed model, at the
/// boundary.
void LocalOptima::compare_with_none() {
  const NonlinearModel fixed = model_.with_random_effects({});
  const auto reached = [&](bool is_restricted) {
    MixedEffectsOptions options = options_;
    options.reml = is_restricted;
    const LindstromBatesSearch found =
        climb_lindstrom_bates(fixed, starts_.front().coefficients, options, Persistence::kOnce);
    const bool is_found = found.outcome.is_valid && found.outcome.converged;
    return is_found ? found.outcome.log_likelihood : kNone;
  };
  const double log_likelihood = reached(options_.reml);
  if (log_likelihood == kNone) return;
  // Fits are ranked by marginal likelihoods, also those by restricted ones.
  contained_.push_back({.text = "without random effects",
                        .log_likelihood = log_likelihood,
                        .rank = options_.reml ? reached(false) : log_likelihood});
}

void LocalOptima::compare_with(const SmallerStructure& smaller) {
  const Candidate best = best_of(ends_);
  const auto found = fixed_point_from(smaller.model, reduced(best.fit, smaller));
  if (!found || !found->convergence.converged()) return;
  const double rank = marginal_log_likelihood(smaller.model, *found, kFirst, options_);
  const bool is_higher = found->log_likelihood > best.fit.log_likelihood + kHigher;
  if (is_higher) {
    contained_.push_back(
        {.text = smaller.text, .log_likelihood = found->log_likelihood, .rank = rank});
  }
  if (!is_higher && !(rank > best.rank + kHigher) && !has_several()) return;
  const std::string origin = "the fit " + smaller.text;
  const MixedEffectsFit start = enlarged(*found, smaller, small_deviation(model_, smaller, *found));
  auto again = fixed_point_from(model_, start);
  if (again) add_end(*std::move(again), origin);
  run_from({.coefficients = found->estimate, .origin = origin});
  climb_from(start);
}

void LocalOptima::add(LocalOptima&& other) {
  for (Candidate& end : other.ends_) add_candidate(ends_, std::move(end));
  for (Candidate& maximum : other.maxima_) add_candidate(maxima_, std::move(maximum));
  std::ranges::move(other.contained_, std::back_inserter(contained_));
}

}  // namespace silvafit::fit
