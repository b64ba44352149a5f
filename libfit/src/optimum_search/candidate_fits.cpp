// SPDX-License-Identifier: MIT
#include "optimum_search/candidate_fits.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"
namespace silvafit::fit {
namespace {

/// A sortable rank: fits without a rank or without convergence are last.
std::pair<bool, double> place_of(const Candidate& candidate) {
  return {candidate.fit.convergence.converged(),
          std::isnan(candidate.rank) ? -kInfinity : candidate.rank};
}

}  // namespace

bool is_in_region(const VectorXd& a, const VectorXd& b) {
  constexpr double kShare = 0.5;
  return ((a - b).array().abs() <= kShare * a.array().abs().max(b.array().abs())).all();
}

bool is_same(const MixedEffectsFit& a, const MixedEffectsFit& b) {
  if (!(std::abs(a.log_likelihood - b.log_likelihood) < kSameLikelihood)) return false;
  constexpr double kSameFit = 1e-2;
  return has_same_curves(a, b, kSameFit);
}

bool has_same_curves(const MixedEffectsFit& a, const MixedEffectsFit& b, double share) {
  const VectorXd change =
      (a.fitted_conditional - b.fitted_conditional).cwiseQuotient(b.residual_sd);
  return change.norm() < share * std::sqrt(static_cast<double>(change.size()));
}

bool add_candidate(std::vector<Candidate>& candidates, Candidate candidate) {
  const auto known = std::ranges::find_if(
      candidates, [&](const Candidate& other) { return is_same(candidate.fit, other.fit); });
  if (known == candidates.end()) {
    candidates.push_back(std::move(candidate));
    return true;
  }
  // A converged fit replaces an unconverged one at the same point, which is not a new point.
  if (candidate.fit.convergence.converged() && !known->fit.convergence.converged()) {
    candidate.rank = known->rank;
    candidate.is_followed = known->is_followed;
    *known = std::move(candidate);
  }
  return false;
}

bool is_far_below(double rank, const Candidate& best) {
  constexpr double kFar = 0.5;
  return best.fit.convergence.converged() &&
         rank < best.rank - kFar * static_cast<double>(best.fit.observations);
}

bool has_converged(const std::vector<Candidate>& candidates) {
  return std::ranges::any_of(
      candidates, [](const Candidate& candidate) { return candidate.fit.convergence.converged(); });
}

double highest_converged(const std::vector<Candidate>& candidates) {
  double result = -kInfinity;
  for (const Candidate& candidate : candidates) {
    if (candidate.fit.convergence.converged()) {
      result = std::max(result, candidate.fit.log_likelihood);
    }
  }
  return result;
}

const Candidate& best_of(const std::vector<Candidate>& candidates) {
  const Candidate* best = &candidates.front();
  for (const Candidate& candidate : candidates) {
    const auto [converged, rank] = place_of(candidate);
    const auto [best_converged, best_rank] = place_of(*best);
    const bool is_higher = converged == best_converged && rank > best_rank + kSameLikelihood;
    if (converged > best_converged || is_higher) best = &candidate;
  }
  return *best;
}

std::vector<LocalOptimum> optima_of(const Candidate& best,
                                    const std::vector<Candidate>& candidates,
                                    bool is_marginal) {
  std::vector<LocalOptimum> result;
  const auto add_optimum = [&](const Candidate& candidate) {
    const double marginal = is_marginal ? kNaN : candidate.rank;
    result.push_back({.origin = candidate.origin,
                      .estimate = candidate.fit.estimate,
                      .log_likelihood = candidate.fit.log_likelihood,
                      .marginal_log_likelihood = marginal});
  };
  add_optimum(best);
  for (const Candidate& candidate : candidates) {
    if (&candidate != &best && candidate.fit.convergence.converged()) add_optimum(candidate);
  }
  std::ranges::stable_sort(
      result.begin() + 1, result.end(), std::ranges::greater(), &LocalOptimum::log_likelihood);
  return result;
}

std::vector<const Candidate*> spread_out(const std::vector<Candidate>& candidates,
                                         std::size_t first) {
  std::vector<const Candidate*> highest;
  for (const Candidate& candidate : candidates) highest.push_back(&candidate);
  std::ranges::stable_sort(highest, [](const Candidate* a, const Candidate* b) {
    return place_of(*a).second > place_of(*b).second;
  });
  std::vector<const Candidate*> result;
  std::vector<const Candidate*> others;
  for (const Candidate* const candidate : highest) {
    const bool is_known = std::ranges::any_of(result, [&](const Candidate* known) {
      return is_in_region(candidate->fit.estimate, known->fit.estimate);
    });
    (is_known && result.size() >= first ? others : result).push_back(candidate);
  }
  result.insert(result.end(), others.begin(), others.end());
  return result;
}

}  // namespace silvafit::fit
