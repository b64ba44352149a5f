// SPDX-License-Identifier: MIT
#include "optimum_search/marginal_maxima.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "mixed_effects/degenerate_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "optimum_search/exchanged_fits.hpp"
#include "optimum_search/smaller_structures.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::VectorXd;

// Smaller differences of log-likelihoods of two ends are within the tolerance of searches.
constexpr double kSameHeight = 0.05;
// For starts after the first ones.
constexpr double kMaximaSeconds = 1.0;

/// Whether searches from two fits begin at about the same curves of all groups.
bool is_near(const MixedEffectsFit& a, const MixedEffectsFit& b) {
  constexpr double kNear = 0.02;  // of the residual standard deviation
  if (!(std::abs(a.log_likelihood - b.log_likelihood) < kSameHeight)) return false;
  const VectorXd change =
      (a.fitted_conditional - b.fitted_conditional).cwiseQuotient(b.residual_sd);
  return change.norm() < kNear * std::sqrt(static_cast<double>(change.size()));
}

/// -infinity without a rank.
double highest_rank(const std::vector<Candidate>& candidates) {
  double result = -std::numeric_limits<double>::infinity();
  for (const Candidate& candidate : candidates) {
    if (candidate.rank > result) result = candidate.rank;
  }
  return result;
}

}  // namespace

MarginalMaxima::MarginalMaxima(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               const OptimumSearchOptions& options,
                               Integration integration,
                               FixedPoints& points)
    : model_(model),
      pooled_(pooled),
      options_(options),
      integration_(integration),
      points_(points),
      budget_(model,
              integration == Integration::kQuadrature ? options.marginal.quadrature_points : 1,
              kMaximaSeconds) {}

void MarginalMaxima::search() {
  follow(starts());
  if (maxima_.empty()) search_longer();
  compare_with_smaller();
  try_exchanged();
  if (!has_converged(maxima_)) search_longer();
  finish_highest();
  prefer_exact_fit();
  if (!is_first_order() && !has_converged(maxima_)) rank_ends();
}

void MarginalMaxima::absorb(MarginalMaxima&& other) {
  for (Candidate& maximum : other.maxima_) add_candidate(maxima_, std::move(maximum));
  std::ranges::move(other.contained_, std::back_inserter(contained_));
  first_order_maximum_ = std::fmax(first_order_maximum_, other.first_order_maximum_);
  prefer_exact_fit();
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
    candidate.rank = value_at(candidate.fit, Integration::kInteraction);
    if (!reason) continue;
    candidate.obstacle = *reason;
    if (candidate.fit.convergence.status == ConvergenceStatus::kDiverged) {
      candidate.fit.convergence.verdict.clear();
    }
  }
}

bool MarginalMaxima::is_first_order() const {
  return integration_ == Integration::kInteraction || integration_ == Integration::kFirstOrder;
}

double MarginalMaxima::value_at(const MixedEffectsFit& fit, Integration integration) const {
  return marginal_log_likelihood(model_, fit, integration, options_.marginal);
}

/// The fixed points and the maxima of other likelihoods, ranked by this one.
std::vector<Candidate> MarginalMaxima::starts() {
  std::vector<Candidate> result = points_.all();
  for (const Candidate& maximum : points_.maxima()) {
    result.push_back({.fit = maximum.fit, .origin = "maximum of a marginal likelihood"});
  }
  if (!is_first_order()) add_first_order_maximum(result);
  if (is_quadrature()) add_laplace_maxima(result);
  for (Candidate& candidate : result) candidate.rank = value_at(candidate.fit, integration_);
  return result;
}

/// The first-order likelihood is valid everywhere and has fewer maxima. Laplace's likelihood is
/// often valid at its maximum, even if it is not at a fixed point.
void MarginalMaxima::add_first_order_maximum(std::vector<Candidate>& starts) {
  const bool holds = points_.ranking() == Integration::kLaplace;
  if (holds && !points_.has_several_ends()) return;
  auto found =
      search_from(model_, best_of(points_.all()).fit, Integration::kInteraction, options_.marginal)
          .fit;
  if (!found) return;
  if (!holds) first_order_maximum_ = found->log_likelihood;
  starts.push_back({.fit = *std::move(found), .origin = "maximum of the first-order likelihood"});
}

/// A value by quadrature costs as much as one value by Laplace's method per point, and the maxima
/// of both are near each other.
void MarginalMaxima::add_laplace_maxima(std::vector<Candidate>& starts) {
  MarginalMaxima laplace(model_, pooled_, options_, Integration::kLaplace, points_);
  laplace.is_preliminary_ = true;
  std::vector<Candidate> first = starts;
  for (Candidate& candidate : first)
    candidate.rank = value_at(candidate.fit, Integration::kLaplace);
  laplace.follow(first);
  has_laplace_maximum_ = has_converged(laplace.maxima_);
  for (const Candidate& maximum : laplace.maxima_) {
    starts.push_back({.fit = maximum.fit, .origin = "maximum of Laplace's likelihood"});
  }
}

/// Searches from the highest starts, then from further ones within the time budget, because a
/// start with a lower likelihood may lead to a higher maximum.
void MarginalMaxima::follow(const std::vector<Candidate>& starts) {
  const std::size_t asked = static_cast<std::size_t>(options_.spread_starts) / 4;
  // The maximum of Laplace's likelihood is the best start for quadrature.
  const bool is_unique = has_laplace_maximum_ && !points_.has_several_ends();
  const std::size_t usual = !is_quadrature() ? 6 : is_unique ? 1 : 3;
  const std::size_t most = usual + 3 * asked;
  // The starts of a likelihood by quadrature are maxima of others, so that the highest are best.
  const std::size_t first = is_quadrature() ? most : most / 2;
  const std::size_t least = is_quadrature() ? most : asked;
  if (is_quadrature()) known_ = highest_rank(starts);
  std::vector<const MixedEffectsFit*> tried;
  for (const Candidate* const start : spread_out(starts, first)) {
    const bool is_enough = tried.size() >= most || (tried.size() >= least && budget_.is_spent());
    if (is_enough && (is_preliminary_ || has_converged(maxima_))) return;
    const bool is_tried = std::ranges::any_of(
        tried, [&](const MixedEffectsFit* other) { return is_near(start->fit, *other); });
    if (is_tried || is_far_below(start->rank, best_of(starts))) continue;
    tried.push_back(&start->fit);
    try_from(start->fit, start->origin);
  }
}

/// If no short search has found a maximum: a longer one from the best start, with all further
/// starts.
void MarginalMaxima::search_longer() {
  if (has_searched_longer_) return;
  has_searched_longer_ = true;
  const Candidate& start = best_of(points_.all());
  MixedEffectsFit first = start.fit;
  describe(model_, first);
  judge(model_, first, Rounds::kAlternations, false);
  MixedEffectsFit found =
      fit_marginal_from(model_, pooled_.estimate, first, integration_, options_.marginal);
  budget_.spend_evaluations(found.convergence.iterations);
  const double rank = found.log_likelihood;
  maxima_.push_back({.fit = std::move(found), .origin = start.origin, .rank = rank});
}

void MarginalMaxima::add(Candidate candidate) {
  candidate.rank = candidate.fit.log_likelihood;
  if (candidate.fit.convergence.converged() && has_diverged(model_, candidate.fit)) {
    candidate.fit.convergence.status = ConvergenceStatus::kDiverged;
    candidate.obstacle.status = ConvergenceStatus::kDiverged;
  }
  add_candidate(maxima_, std::move(candidate));
}

/// With few quadrature points the maximum is near that with more, which is sufficient for a
/// smaller structure.
MarginalOptions MarginalMaxima::coarse_options() const {
  constexpr int kFew = 3;
  MarginalOptions result = options_.marginal;
  result.quadrature_points = std::min(result.quadrature_points, kFew);
  return result;
}

bool MarginalMaxima::is_quadrature() const { return integration_ == Integration::kQuadrature; }

MarginalEnd MarginalMaxima::search_from(const NonlinearModel& model,
                                        const MixedEffectsFit& start,
                                        Integration integration,
                                        const MarginalOptions& options,
                                        const MarginalEffort& effort) {
  MarginalEnd end = marginal_from(model, start, integration, options, effort);
  budget_.spend_evaluations(end.evaluations);
  return end;
}

void MarginalMaxima::try_from(const MixedEffectsFit& start, const std::string& origin) {
  MarginalEnd end = search_from(model_,
                                start,
                                integration_,
                                options_.marginal,
                                {.known = std::max(known_, highest_converged(maxima_))});
  if (!end.fit) return;
  add({.fit = *std::move(end.fit), .origin = origin, .obstacle = std::move(end.obstacle)});
}

void MarginalMaxima::compare_with_smaller() {
  points_.add_without_random_effects(contained_);
  for (const SmallerStructure& smaller : points_.structures_to_compare()) {
    if (budget_.is_spent() || maxima_.empty()) break;
    const MixedEffectsFit before = best_of(maxima_).fit;
    if (!std::isfinite(before.log_likelihood)) break;
    auto found =
        search_from(smaller.model, reduced(before, smaller), integration_, coarse_options()).fit;
    if (found && is_quadrature()) {
      found->log_likelihood =
          marginal_log_likelihood(smaller.model, *found, integration_, options_.marginal);
    }
    if (!found || !found->convergence.converged()) continue;
    const bool is_above = is_higher(*found, before);
    if (is_above) {
      contained_.push_back({.text = smaller.text,
                            .log_likelihood = found->log_likelihood,
                            .rank = found->log_likelihood});
    }
    if (!is_above && !points_.has_several_ends()) continue;
    try_from(enlarged(*found, smaller, small_deviation(model_, smaller, before)),
             "the fit " + smaller.text);
  }
}

/// With random effects on one of two interchangeable terms, the best fit may belong to the other.
void MarginalMaxima::try_exchanged() {
  if (maxima_.empty()) return;
  const MixedEffectsFit best = best_of(maxima_).fit;
  for (const MixedEffectsFit& start : exchanged_fits(model_, best)) {
    if (!budget_.is_spent()) try_from(start, std::string(kExchangedOrigin));
  }
}

/// Continues a search that was stopped at the highest point, or ended there with few digits, unless
/// the likelihood is not valid beyond it.
void MarginalMaxima::finish_highest() {
  const auto place = std::ranges::max_element(maxima_, {}, [](const Candidate& candidate) {
    const double value = candidate.fit.log_likelihood;
    return std::isnan(value) ? -std::numeric_limits<double>::infinity() : value;
  });
  if (place == maxima_.end()) return;
  const Candidate start = *place;
  constexpr double kExact = 1e-9;  // squared standard errors
  const bool is_finished =
      start.fit.convergence.converged() && start.fit.convergence.newton_decrement <= kExact;
  const bool has_end =
      start.obstacle.status != ConvergenceStatus::kInvalidApproximation || !has_converged(maxima_);
  if (is_finished || !has_end || !std::isfinite(start.fit.log_likelihood)) return;
  MarginalEnd end =
      marginal_from(model_, start.fit, integration_, options_.marginal, {.is_complete = true});
  if (!end.fit) return;
  if (is_same(*end.fit, start.fit) &&
      end.fit->convergence.newton_decrement < start.fit.convergence.newton_decrement) {
    place->fit = *std::move(end.fit);
    place->rank = place->fit.log_likelihood;
    return;
  }
  add({.fit = *std::move(end.fit), .origin = start.origin, .obstacle = std::move(end.obstacle)});
}

/// The highest point at which a search has not converged, if it is above a maximum. Laplace's
/// likelihood increases without bound towards points at which it is not valid. Therefore the
/// first-order one, which is bounded, must be higher there, too.
/// \param difference  of log-likelihoods, at least
const Candidate* MarginalMaxima::unfinished_above(const MixedEffectsFit& fit,
                                                  double difference) const {
  const double here = is_first_order() ? kNaN : value_at(fit, Integration::kInteraction);
  const Candidate* highest = nullptr;
  for (const Candidate& candidate : maxima_) {
    const double value = candidate.fit.log_likelihood;
    if (candidate.fit.convergence.converged() || !(value > fit.log_likelihood + difference)) {
      continue;
    }
    const bool counts =
        is_first_order() || value_at(candidate.fit, Integration::kInteraction) > here + difference;
    if (counts && (!highest || value > highest->fit.log_likelihood)) highest = &candidate;
  }
  return highest;
}

/// A maximum far below a point that was reached elsewhere says nothing about the data.
const Candidate& MarginalMaxima::best() const {
  constexpr double kFar = 20.0;
  const Candidate& best = best_of(maxima_);
  if (!best.fit.convergence.converged()) return best;
  const Candidate* const higher = unfinished_above(best.fit, kFar);
  return higher ? *higher : best;
}

SearchEvidence MarginalMaxima::evidence(const Candidate& best) const {
  SearchEvidence result;
  result.method = integration_;
  const MixedEffectsFit& found = best.fit;
  result.contained = higher_than(found.log_likelihood, contained_);
  result.first_order_maximum = first_order_maximum_;
  const Candidate* const higher = unfinished_above(found, kSameHeight);
  result.unfinished = higher ? higher->fit.log_likelihood : kNaN;
  return result;
}

}  // namespace silvafit::fit
