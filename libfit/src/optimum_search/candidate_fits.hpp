// SPDX-License-Identifier: MIT
// Fits that the starts of a search have led to, and which of them is the best.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "mixed_effects/mixed_effects_evidence.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

struct Candidate {
  MixedEffectsFit fit{};
  std::string origin{};
  Obstacle obstacle{};  ///< of a fit that has not converged
  /// Log-likelihood that tells which is the best.
  double rank = std::numeric_limits<double>::quiet_NaN();
  bool is_followed = false;  ///< whether the marginal maximum near it is known
};

/// Whether two fits are the same point but for the tolerance of their searches: their likelihoods
/// and fitted values agree.
bool is_same(const MixedEffectsFit& a, const MixedEffectsFit& b);

/// Adds a fit at a place that is not known yet; false if it is. A fit that has converged replaces
/// one at the same place that has not.
bool add_candidate(std::vector<Candidate>& candidates, Candidate candidate);

bool has_converged(const std::vector<Candidate>& candidates);

/// The highest log-likelihood of those that have converged; -infinity where none has.
double highest_converged(const std::vector<Candidate>& candidates);

/// Fits that have converged come first, then those of higher rank; of equal ones the first.
/// \param candidates  at least one
const Candidate& best_of(const std::vector<Candidate>& candidates);

/// The best and the others that have converged, from high to low, for reports.
/// \param is_marginal  whether the fits' own likelihood is a marginal one
std::vector<LocalOptimum> optima_of(const Candidate& best,
                                    const std::vector<Candidate>& candidates,
                                    bool is_marginal);

/// All of them, whether or not they have converged, those of the highest rank first, but after some
/// the highest ones of other regions: the highest start does not always lead to the highest
/// optimum.
/// \param first  how many come by their rank alone
std::vector<const Candidate*> spread_out(const std::vector<Candidate>& candidates,
                                         std::size_t first);

}  // namespace silvafit::fit
