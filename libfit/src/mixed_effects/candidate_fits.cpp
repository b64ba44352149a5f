// SPDX-License-Identifier: MIT
#include "mixed_effects/candidate_fits.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace silvafit::fit {
namespace {

using Eigen::VectorXd;

// Log-likelihoods of two methods or linearizations that differ by less are taken for equal.
constexpr double kSameLikelihood = 1e-3;

/// A rank that can be sorted: without one, and without convergence, last.
std::pair<bool, double> place_of(const Candidate& candidate) {
  return {candidate.fit.convergence.converged,
          std::isnan(candidate.rank) ? -std::numeric_limits<double>::infinity() : candidate.rank};
}

}  // namespace

bool is_same(const MixedEffectsFit& a, const MixedEffectsFit& b) {
  if (a.convergence.converged != b.convergence.converged) return false;
  if (!(std::abs(a.log_likelihood - b.log_likelihood) < kSameLikelihood)) return false;
  constexpr double kSameFit = 1e-2;  // of the residual standard deviation
  const VectorXd change =
      (a.fitted_conditional - b.fitted_conditional).cwiseQuotient(b.residual_sd);
  return change.norm() < kSameFit * std::sqrt(static_cast<double>(change.size()));
}

bool add_candidate(std::vector<Candidate>& candidates, Candidate candidate) {
  const bool is_known = std::ranges::any_of(
      candidates, [&](const Candidate& other) { return is_same(candidate.fit, other.fit); });
  if (is_known) return false;
  candidates.push_back(std::move(candidate));
  return true;
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

std::vector<const Candidate*> best_few(const std::vector<Candidate>& candidates,
                                       std::size_t count) {
  std::vector<const Candidate*> result;
  for (const Candidate& candidate : candidates) result.push_back(&candidate);
  std::ranges::stable_sort(
      result, [](const Candidate* a, const Candidate* b) { return place_of(*a) > place_of(*b); });
  result.resize(std::min(count, result.size()));
  return result;
}

}  // namespace silvafit::fit
