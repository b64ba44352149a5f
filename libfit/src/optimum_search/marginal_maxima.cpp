// SPDX-License-Identifier: MIT
#include "optimum_search/marginal_maxima.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "least_squares/start_search.hpp"
#include "mixed_effects/degenerate_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimization/tolerances.hpp"
#include "optimum_search/exchanged_fits.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "silvafit/base/constants.hpp"
#include "verdict/thresholds.hpp"

namespace silvafit::fit {

MarginalMaxima::MarginalMaxima(const NonlinearModel& model,
                               const VectorXd& pooled,
                               Method method,
                               const MixedEffectsOptions& options,
                               const LocalOptima& found)
    : model_(model),
      pooled_(pooled),
      method_(method),
      is_first_order_(method == Method::kInteraction || method == Method::kFirstOrder),
      options_(options),
      found_(found),
      contained_(found.contained()) {
  // Those of other likelihoods; the one without random effects is the same for all.
  std::erase_if(contained_, [](const ContainedModel& smaller) {
    return smaller.log_likelihood != smaller.rank;
  });
}

void MarginalMaxima::search(std::size_t most) {
  std::vector<Candidate> all = starts();
  if (method_ == Method::kQuadrature) add_laplace_maxima(all);
  follow(all, most);
  compare_with_smaller();
  try_exchanged();
  search_across_kinks();
  if (!has_converged(maxima_)) search_longer();
  finish_highest();
  prefer_exact_fit();
  if (!is_first_order_ && !has_converged(maxima_)) rank_ends();
}

double MarginalMaxima::value_at(const MixedEffectsFit& fit, Method method) const {
  return marginal_log_likelihood(model_, fit, method, options_);
}

/// The local optima, ranked by this likelihood.
std::vector<Candidate> MarginalMaxima::starts() const {
  std::vector<Candidate> result = found_.maxima();
  for (const Candidate& end : found_.ends()) result.push_back(end);
  if (method_ == Method::kInteraction) return result;
  for (Candidate& start : result) start.rank = value_at(start.fit, method_);
  return result;
}

/// A value by quadrature costs as much as one value by Laplace's method per point, and the maxima
/// of both are near each other.
void MarginalMaxima::add_laplace_maxima(std::vector<Candidate>& starts) const {
  MarginalMaxima laplace(model_, pooled_, Method::kLaplace, options_, found_);
  laplace.follow(laplace.starts(), kClimbs);
  for (const Candidate& maximum : laplace.maxima_) {
    Candidate& start = starts.emplace_back();
    start.fit = maximum.fit;
    start.origin = "maximum of Laplace's likelihood";
    start.rank = value_at(maximum.fit, method_);
  }
}

void MarginalMaxima::follow(const std::vector<Candidate>& all, std::size_t most) {
  std::vector<const Candidate*> tried;
  for (const Candidate* const start : spread_out(all, most)) {
    if (tried.size() >= most && has_converged(maxima_)) return;
    const bool is_tried = std::ranges::any_of(
        tried, [&](const Candidate* other) { return is_same(start->fit, other->fit); });
    if (is_tried || is_far_below(start->rank, best_of(all))) continue;
    tried.push_back(start);
    try_from(start->fit, start->origin);
  }
}

void MarginalMaxima::try_from(const MixedEffectsFit& start, const std::string& origin) {
  add(marginal_from(model_, start, method_, options_, {.known = highest_converged(maxima_)}),
      origin);
}

void MarginalMaxima::add(MarginalEnd end, const std::string& origin) {
  if (!end.fit) return;
  Candidate candidate{
      .fit = *std::move(end.fit), .origin = origin, .obstacle = std::move(end.obstacle)};
  candidate.rank = candidate.fit.log_likelihood;
  if (candidate.fit.convergence.converged() && has_diverged(model_, candidate.fit)) {
    candidate.fit.convergence.status = ConvergenceStatus::kDiverged;
    candidate.obstacle.status = ConvergenceStatus::kDiverged;
  }
  add_candidate(maxima_, std::move(candidate));
}

void MarginalMaxima::compare_with_smaller() {
  for (const SmallerStructure& smaller : smaller_structures(model_)) {
    if (maxima_.empty()) return;
    compare_with(smaller);
  }
}

/// A smaller structure with a higher maximum is evidence. It is a start, too, and others are where
/// several optima are known.
void MarginalMaxima::compare_with(const SmallerStructure& smaller) {
  const MixedEffectsFit best = best_of(maxima_).fit;
  if (!std::isfinite(best.log_likelihood)) return;
  MarginalEffort effort;
  if (!found_.has_several()) effort.known = best.log_likelihood;
  // With few points of quadrature the maximum is near that with more.
  MixedEffectsOptions coarse = options_;
  coarse.quadrature_points = std::min(coarse.quadrature_points, 3);
  const MarginalEnd end =
      marginal_from(smaller.model, reduced(best, smaller), method_, coarse, effort);
  if (!end.fit || !end.fit->convergence.converged()) return;
  const double height = method_ == Method::kQuadrature
                            ? marginal_log_likelihood(smaller.model, *end.fit, method_, options_)
                            : end.fit->log_likelihood;
  const bool is_higher = height > best.log_likelihood + kHigher;
  if (is_higher) {
    contained_.push_back({.text = smaller.text, .log_likelihood = height, .rank = height});
  }
  if (!is_higher && !found_.has_several()) return;
  try_from(enlarged(*end.fit, smaller, small_deviation(model_, smaller, best)),
           "the fit " + smaller.text);
}

/// With random effects on one of two interchangeable terms, the best fit may belong to the other.
void MarginalMaxima::try_exchanged() {
  if (maxima_.empty()) return;
  const MixedEffectsFit best = best_of(maxima_).fit;
  for (const MixedEffectsFit& start : exchanged_fits(model_, best)) {
    try_from(start, std::string(kExchangedOrigin));
  }
}

/// Of the maxima on both sides of each observation's kink, the best may be another one.
void MarginalMaxima::search_across_kinks() {
  if (!has_converged(maxima_)) return;
  MixedEffectsFit start = best_of(maxima_).fit;
  VectorXd errors = start.covariance.diagonal().cwiseSqrt();
  // The likelihood is smooth in coefficients that vary between groups.
  for (const std::string& name : model_.random_kinks()) {
    const Index j = model_.coefficient_index(name);
    if (j < errors.size()) errors[j] = kNaN;
  }
  for (VectorXd& point : points_across_kinks(model_, start.estimate, errors)) {
    start.estimate = std::move(point);
    try_from(start, "beyond a kink");
  }
}

/// If no short search has found a maximum: a longer one from the best start, with all further
/// starts.
void MarginalMaxima::search_longer() {
  if (found_.ends().empty()) return;
  const Candidate& start = best_of(found_.ends());
  MixedEffectsFit first = start.fit;
  describe(model_, first);
  judge(model_, first, Rounds::kAlternations, false);
  MixedEffectsFit found = fit_marginal_from(model_, pooled_, first, method_, options_);
  const double rank = found.log_likelihood;
  maxima_.push_back({.fit = std::move(found), .origin = start.origin, .rank = rank});
}

/// Continues a search that was stopped at the highest point, or ended there with few digits, unless
/// the likelihood is not valid beyond it.
void MarginalMaxima::finish_highest() {
  const auto place = std::ranges::max_element(maxima_, {}, [](const Candidate& candidate) {
    const double value = candidate.fit.log_likelihood;
    return std::isnan(value) ? -kInfinity : value;
  });
  if (place == maxima_.end()) return;
  const Candidate start = *place;
  constexpr double kExact = 1e-9;  // squared standard errors
  const bool is_finished =
      start.fit.convergence.converged() && start.fit.convergence.newton_decrement <= kExact;
  const bool has_end =
      start.obstacle.status != ConvergenceStatus::kInvalidApproximation || !has_converged(maxima_);
  if (is_finished || !has_end || !std::isfinite(start.fit.log_likelihood)) return;
  MarginalEnd end = marginal_from(model_, start.fit, method_, options_, {.is_complete = true});
  if (!end.fit) return;
  if (is_same(*end.fit, start.fit) &&
      end.fit->convergence.newton_decrement < start.fit.convergence.newton_decrement) {
    place->fit = *std::move(end.fit);
    place->rank = place->fit.log_likelihood;
    return;
  }
  add(std::move(end), start.origin);
}

/// Towards a fit of all observations the likelihood increases without bound, so that maxima
/// elsewhere do not count.
void MarginalMaxima::prefer_exact_fit() {
  const double highest = highest_converged(maxima_);
  const bool has_exact_fit = std::ranges::any_of(maxima_, [&](const Candidate& candidate) {
    const MixedEffectsFit& fit = candidate.fit;
    return !fit.convergence.converged() && fit.log_likelihood > highest &&
           fits_exactly(model_, fit);
  });
  if (!has_exact_fit) return;
  std::erase_if(maxima_,
                [](const Candidate& candidate) { return candidate.fit.convergence.converged(); });
}

/// If no search has converged, the highest end may be far away, at a point near which the
/// likelihood increases without bound. The end with the highest first-order likelihood is reported,
/// with the reason why there is no maximum if a search has found it.
void MarginalMaxima::rank_ends() {
  const auto invalid = std::ranges::find(
      maxima_, ConvergenceStatus::kInvalidApproximation, [](const Candidate& candidate) {
        return candidate.obstacle.status;
      });
  std::optional<Obstacle> reason;
  if (invalid != maxima_.end()) reason = invalid->obstacle;
  for (Candidate& candidate : maxima_) {
    candidate.rank = value_at(candidate.fit, Method::kInteraction);
    if (!reason) continue;
    candidate.obstacle = *reason;
    if (candidate.fit.convergence.status == ConvergenceStatus::kDiverged) {
      candidate.fit.convergence.findings.clear();
    }
  }
}

/// The highest point at which a search has not converged, if it is above a maximum. Laplace's
/// likelihood increases without bound towards points at which it is not valid. Therefore the
/// first-order one, which is bounded, must be higher there, too.
/// \param difference  of log-likelihoods, at least
const Candidate* MarginalMaxima::unfinished_above(const MixedEffectsFit& fit,
                                                  double difference) const {
  const double here = is_first_order_ ? kNaN : value_at(fit, Method::kInteraction);
  const Candidate* highest = nullptr;
  for (const Candidate& candidate : maxima_) {
    const double value = candidate.fit.log_likelihood;
    if (candidate.fit.convergence.converged() || !(value > fit.log_likelihood + difference)) {
      continue;
    }
    const bool counts =
        is_first_order_ || value_at(candidate.fit, Method::kInteraction) > here + difference;
    if (counts && (!highest || value > highest->fit.log_likelihood)) highest = &candidate;
  }
  return highest;
}

const Candidate& MarginalMaxima::best() const {
  const Candidate& best = best_of(maxima_);
  if (!best.fit.convergence.converged()) return best;
  const Candidate* const higher = unfinished_above(best.fit, Thresholds::kFarBelow);
  return higher ? *higher : best;
}

SearchEvidence MarginalMaxima::evidence(const Candidate& best) const {
  SearchEvidence result;
  result.method = method_;
  const MixedEffectsFit& found = best.fit;
  result.contained = higher_than(found.log_likelihood, contained_);
  const Candidate* const higher = unfinished_above(found, kHigher);
  result.unfinished = higher ? higher->fit.log_likelihood : kNaN;
  // Where Laplace's likelihood is not valid, its maxima are far below the first-order one.
  if (!is_first_order_ && !found_.maxima().empty()) {
    const Candidate& first = best_of(found_.maxima());
    const bool is_valid = std::isfinite(value_at(first.fit, Method::kLaplace));
    if (!is_valid) result.first_order_maximum = first.rank;
  }
  return result;
}

}  // namespace silvafit::fit
