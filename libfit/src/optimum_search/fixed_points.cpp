// SPDX-License-Identifier: MIT
#include "optimum_search/fixed_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string_view>
#include <utility>

#include "marginal_likelihood/marginal_fit.hpp"
#include "model/symmetric_eigen.hpp"
#include "optimum_search/exchanged_fits.hpp"
#include "optimum_search/group_fits.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Tolerance for a likelihood below that of a nested model: linearizations at nearly the same point
// differ by this much.
constexpr double kSlack = 0.05;
// Standard deviations of random effects at the starts, relative to the usual one.
constexpr double kNarrow = 0.1;
constexpr double kVeryNarrow = 0.01;
constexpr std::string_view kMaximumOrigin = "maximum of the marginal likelihood";
// For starts after the first ones.
constexpr double kFixedPointSeconds = 2.0;

/// Coefficients of a group that is drawn from the distribution of a fit's random effects.
VectorXd drawn_group(const NonlinearModel& model,
                     const MixedEffectsFit& fit,
                     std::uint64_t number) {
  constexpr std::uint64_t kSeed = 2;
  Random random(kSeed, number);
  VectorXd result = fit.estimate;
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
  return result;
}

}  // namespace

bool is_higher(const MixedEffectsFit& smaller, const MixedEffectsFit& whole) {
  return smaller.convergence.converged() && smaller.log_likelihood > whole.log_likelihood + kSlack;
}

FixedPoints::FixedPoints(const NonlinearModel& model,
                         const LeastSquaresFit& pooled,
                         const OptimumSearchOptions& options,
                         const VectorXd& from_part,
                         Starts starts)
    : model_(model),
      pooled_(pooled),
      options_(options),
      linearized_(options.linearized),
      from_part_(from_part),
      starts_(starts),
      budget_(model, 1, kFixedPointSeconds) {
  linearized_.starts.clear();
}

std::vector<StartingPoint> FixedPoints::points() const {
  std::vector<StartingPoint> result;
  if (starts_ == Starts::kGiven) {
    for (const VectorXd& start : options_.linearized.starts) {
      result.push_back({.coefficients = start, .origin = std::string(kStartValues)});
    }
    return result;
  }
  if (from_part_.size() == 0) return starting_points(model_, pooled_, options_.spread_starts);
  result.push_back({.coefficients = pooled_.estimate, .origin = std::string(kPooledFit)});
  result.push_back({.coefficients = from_part_, .origin = "a part of the observations"});
  return result;
}

void FixedPoints::search() {
  const std::vector<StartingPoint> starts = points();
  first_ = starts.front();
  for (std::size_t k = 0; k < starts.size(); ++k) {
    // The user's starts and the pooled fit are tried at any cost.
    const bool is_asked = starts_ == Starts::kGiven || k == 0 || starts[k].origin == kSpreadStart;
    if (!is_asked && budget_.is_spent() && has_converged(candidates_)) continue;
    const bool is_reached = linearize_from(starts[k], Persistence::kOnce);
    const bool is_minimum = starts[k].origin == kPooledFit || starts[k].origin == kOtherMinimum;
    if (!is_reached && is_minimum) failed_.push_back(starts[k].coefficients);
    if (starts[k].with_effects) start_with_effects_of(starts[k]);
    if (starts_ == Starts::kFound) continue;
    // With narrow random effects the run stays near its starting coefficients.
    for (const double spread : {kNarrow, kVeryNarrow}) {
      linearize_from(starts[k], Persistence::kOnce, spread);
    }
  }
  if (starts_ == Starts::kFound && has_several_ends()) {
    linearize_from(first_, Persistence::kOnce, kNarrow);
  }
  const bool has_random = !model_.specification().random.empty();
  if (has_random ? candidates_.empty() : !has_converged(candidates_)) search_longer();
}

void FixedPoints::search_longer() { linearize_from(first_, Persistence::kUntilFound); }

void FixedPoints::start_with_effects_of(const StartingPoint& point) {
  auto found = fixed_point_from(model_, *point.with_effects);
  if (found) add_candidate(candidates_, {.fit = *std::move(found), .origin = point.origin});
}

bool FixedPoints::linearize_from(const StartingPoint& point,
                                 Persistence persistence,
                                 double spread) {
  LindstromBatesSearch found =
      climb_lindstrom_bates(model_, point.coefficients, linearized_, persistence, spread);
  // The user's further starts are additional to all others.
  if (point.origin != kSpreadStart) budget_.spend_work(found.work);
  if (!found.outcome.is_valid) return false;
  add_candidate(candidates_,
                {.fit = found.engine->result(found.outcome),
                 .origin = point.origin,
                 .obstacle = found.outcome.obstacle});
  return found.outcome.converged;
}

void FixedPoints::rank() {
  for (const Integration integration : {Integration::kLaplace, Integration::kInteraction}) {
    ranking_ = integration;
    bool holds = true;
    for (Candidate& candidate : candidates_) {
      candidate.rank =
          marginal_log_likelihood(model_, candidate.fit, integration, options_.marginal);
      holds = holds && std::isfinite(candidate.rank);
    }
    if (holds) return;
  }
}

/// Whether the comparison of starts on a part of the observations was sufficient: with all
/// observations there is one fixed point, and its likelihood is near the marginal one.
bool FixedPoints::is_settled() const {
  constexpr double kNear = 2.0;
  return from_part_.size() > 0 && candidates_.size() == 1 &&
         std::abs(candidates_.front().rank - candidates_.front().fit.log_likelihood) < kNear;
}

/// Whether there are several fixed points with similar likelihoods; there may then be many more.
bool FixedPoints::has_similar_fixed_points() const {
  constexpr double kClose = 10.0;
  if (from_part_.size() > 0) return false;
  const double best = best_of(candidates_).rank;
  return std::ranges::count_if(candidates_, [&](const Candidate& candidate) {
           return candidate.fit.convergence.converged() && candidate.rank > best - kClose;
         }) > 1;
}

/// Further starts if there are many fixed points: coefficients of groups, drawn from the
/// distribution of the best fit; repeated after a better fit was found.
void FixedPoints::explore() {
  constexpr std::uint64_t kStarts = 8;
  constexpr std::uint64_t kRounds = 3;
  for (std::uint64_t round = 0; round < kRounds && has_similar_fixed_points(); ++round) {
    const MixedEffectsFit best = best_of(candidates_).fit;
    const double before = best_of(candidates_).rank;
    for (std::uint64_t k = 0; k < kStarts && !budget_.is_spent(); ++k) {
      linearize_from({.coefficients = drawn_group(model_, best, round * kStarts + k),
                      .origin = "a drawn group"},
                     Persistence::kOnce);
    }
    rank();
    if (!(best_of(candidates_).rank > before + kSlack)) return;
  }
}

void FixedPoints::compare() {
  rank();
  if (is_settled()) return compare_with_smaller();
  start_from_failed();
  follow_to_maxima();
  start_from_own_minima();
  if (!has_converged(candidates_)) search_longer();
  start_from_maxima();
  explore();
  compare_with_smaller();
  follow_to_maxima();
  find_own_maximum();
}

/// After a change of the ranking the known maxima may belong to another likelihood or to other
/// regions: a maximum below the best fixed point gives no information about it.
void FixedPoints::find_own_maximum() {
  const Candidate& best = best_of(candidates_);
  const double highest =
      ranking_ == Integration::kLaplace ? highest_laplace_ : highest_first_order_;
  const bool is_unknown = ranking_ == Integration::kLaplace && !std::isfinite(highest);
  if (is_unknown || highest >= best.rank - kSlack) return;
  const MixedEffectsFit start = best.fit;
  follow_to_maximum(start);
  rank();
}

void FixedPoints::compare_briefly() {
  rank();
  // From maxima of a marginal likelihood the method often finds a fixed point although it failed
  // from all other starts.
  if (!has_converged(candidates_)) follow_to_maxima();
  if (!has_converged(candidates_)) search_longer();
  explore();
  compare_with_smaller();
}

void FixedPoints::absorb(FixedPoints&& other) {
  for (Candidate& candidate : other.candidates_) add_candidate(candidates_, std::move(candidate));
  for (Candidate& maximum : other.maxima_) add_candidate(maxima_, std::move(maximum));
  std::ranges::move(other.contained_, std::back_inserter(contained_));
  highest_laplace_ = std::max(highest_laplace_, other.highest_laplace_);
  highest_first_order_ = std::max(highest_first_order_, other.highest_first_order_);
  rank();
}

/// Runs from the maximum of the marginal likelihood near each of the best fixed points, then near
/// the fixed points that these find.
void FixedPoints::follow_to_maxima() {
  constexpr int kRounds = 3;
  constexpr std::size_t kBest = 4;
  constexpr int kFarBelow = 1;  // in the first round
  for (int round = 0; round < kRounds && !budget_.is_spent(); ++round) {
    const std::size_t known = candidates_.size();
    const Candidate& highest = best_of(candidates_);
    std::vector<MixedEffectsFit> starts;
    std::vector<const Candidate*> best = spread_out(candidates_, kBest - 1);
    best.resize(std::min(kBest, best.size()));
    int useless = round == 0 ? 0 : kFarBelow;
    for (const Candidate* const candidate : best) {
      const bool is_useless = is_far_below(candidate->rank, highest) && ++useless > kFarBelow;
      if (!candidate->is_followed && !is_useless) starts.push_back(candidate->fit);
    }
    for (Candidate& candidate : candidates_) {
      candidate.is_followed =
          candidate.is_followed || std::ranges::any_of(starts, [&](const MixedEffectsFit& fit) {
            return is_same(candidate.fit, fit);
          });
    }
    for (const MixedEffectsFit& start : starts) {
      if (!budget_.is_spent()) follow_to_maximum(start);
    }
    if (candidates_.size() == known) return;
    rank();
  }
}

std::optional<MixedEffectsFit> FixedPoints::fixed_point_from(const NonlinearModel& model,
                                                             const MixedEffectsFit& start) {
  LindstromBatesEnd end = lindstrom_bates_from(model, start, linearized_);
  budget_.spend_work(end.work);
  return std::move(end.fit);
}

std::optional<MixedEffectsFit> FixedPoints::maximum_from(const MixedEffectsFit& start,
                                                         Integration integration) {
  MarginalEnd end = marginal_from(model_, start, integration, options_.marginal);
  budget_.spend_evaluations(end.evaluations);
  return std::move(end.fit);
}

void FixedPoints::follow_to_maximum(const MixedEffectsFit& start) {
  Integration integration = ranking_;
  auto maximum = maximum_from(start, integration);
  const bool is_found = maximum && maximum->convergence.converged();
  if (!is_found && integration != Integration::kInteraction) {
    integration = Integration::kInteraction;
    maximum = maximum_from(start, integration);
  }
  if (!maximum || !std::isfinite(maximum->log_likelihood)) return;
  add_maximum(*maximum, integration);
}

void FixedPoints::add_maximum(const MixedEffectsFit& maximum, Integration integration) {
  double& highest = integration == Integration::kLaplace ? highest_laplace_ : highest_first_order_;
  highest = std::max(highest, maximum.log_likelihood);
  if (!add_candidate(maxima_, {.fit = maximum})) return;
  if (auto found = fixed_point_from(model_, maximum)) {
    add_candidate(candidates_, {.fit = *std::move(found), .origin = std::string(kMaximumOrigin)});
  }
}

/// Runs with the groups' own minima around the best fixed point, again after a better one was
/// found.
void FixedPoints::start_from_own_minima() {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds && !budget_.is_spent(); ++round) {
    const std::size_t known = candidates_.size();
    const double before = best_of(candidates_).rank;
    const auto start = start_at_own_minima(model_, best_of(candidates_).fit.estimate);
    if (!start) return;
    auto found = fixed_point_from(model_, *start);
    if (found) {
      add_candidate(candidates_, {.fit = *std::move(found), .origin = "own minima of groups"});
    }
    if (candidates_.size() == known) return;
    rank();
    follow_to_maxima();
    if (!(best_of(candidates_).rank > before + kSlack)) return;
  }
}

/// A failed run from a pooled minimum ends anywhere. Searches of the first-order likelihood, which
/// is bounded and smooth, begin at the minimum itself. They have a budget of their own.
void FixedPoints::start_from_failed() {
  constexpr double kSeconds = 2.0;
  std::erase_if(failed_, [&](const VectorXd& start) {
    return std::ranges::any_of(candidates_, [&](const Candidate& candidate) {
      return candidate.fit.convergence.converged() && is_in_region(candidate.fit.estimate, start);
    });
  });
  if (failed_.empty()) return;
  SearchBudget others(model_, 1, kSeconds);
  std::swap(budget_, others);
  const std::size_t known = candidates_.size();
  for (const VectorXd& start : failed_) {
    if (budget_.is_spent()) break;
    MarginalEnd end =
        marginal_from_coefficients(model_, start, Integration::kInteraction, options_.marginal);
    budget_.spend_evaluations(end.evaluations);
    std::optional<MixedEffectsFit> fit = std::move(end.fit);
    while (fit && !fit->convergence.converged() && !budget_.is_spent()) {
      auto next = maximum_from(*fit, Integration::kInteraction);
      if (!next || !(next->log_likelihood > fit->log_likelihood + kSlack)) break;
      fit = std::move(next);
    }
    if (fit && std::isfinite(fit->log_likelihood)) add_maximum(*fit, Integration::kInteraction);
  }
  std::swap(budget_, others);
  if (candidates_.size() > known) rank();
}

/// Runs from the coefficients of the maxima, with other random effects.
void FixedPoints::start_from_maxima() {
  if (!has_several_ends()) return;
  const Candidate best = best_of(candidates_);
  for (const Candidate& maximum : maxima_) {
    if (is_far_below(maximum.fit.log_likelihood, best)) continue;
    const StartingPoint point{.coefficients = maximum.fit.estimate,
                              .origin = std::string(kMaximumOrigin)};
    for (const double spread : {kVeryNarrow, 1.0}) {
      if (!budget_.is_spent()) linearize_from(point, Persistence::kOnce, spread);
    }
  }
  rank();
  follow_to_maxima();
}

SearchEvidence FixedPoints::evidence(const Candidate& best) const {
  SearchEvidence result;
  const double highest = std::max(highest_laplace_, highest_first_order_);
  std::vector<ContainedModel> higher = contained_;
  if (!options_.linearized.reml) {
    std::erase_if(higher, [&](const ContainedModel& model) {
      return !(model.log_likelihood > best.fit.log_likelihood + kSlack);
    });
  }
  result.contained = higher_than(best.rank, higher);
  result.is_restricted = options_.linearized.reml;
  result.marginal = ranking_;
  result.marginal_here = best.rank;
  result.marginal_maximum =
      ranking_ == Integration::kLaplace ? highest_laplace_ : highest_first_order_;
  // Laplace's likelihood may be valid at all fixed points but have no maximum nearby.
  if (!std::isfinite(result.marginal_maximum) && std::isfinite(highest)) {
    result.marginal = Integration::kInteraction;
    result.marginal_here =
        marginal_log_likelihood(model_, best.fit, Integration::kInteraction, options_.marginal);
    result.marginal_maximum = highest_first_order_;
  }
  // Searches from the fit may have failed, and others have ended at lower maxima elsewhere.
  if (result.marginal_maximum < result.marginal_here) {
    result.marginal_maximum = result.marginal_here;
  }
  return result;
}

}  // namespace silvafit::fit
