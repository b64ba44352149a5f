// SPDX-License-Identifier: MIT
// The fits from the starts of a search, and the best of them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mixed_effects/mixed_effects_evidence.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

struct Candidate {
  MixedEffectsFit fit{};
  std::string origin{};
  Obstacle obstacle{};  ///< of a fit that has not converged
  /// Log-likelihood by which fits are ranked.
  double rank = kNaN;
  bool is_followed = false;  ///< whether the marginal maximum near it was searched
};

/// Whether two fits are the same point within the tolerance of their searches: their likelihoods
/// and fitted values agree.
bool is_same(const MixedEffectsFit& a, const MixedEffectsFit& b);

/// Whether the curves of all groups differ by less than a share of the residuals' scatter around
/// them.
bool has_same_curves(const MixedEffectsFit& a, const MixedEffectsFit& b, double share);

/// Adds a fit at a new point; false if the point is known. A converged fit replaces an unconverged
/// one at the same point.
bool add_candidate(std::vector<Candidate>& candidates, Candidate candidate);

/// Whether coefficients have the same signs and similar sizes.
bool is_in_region(const VectorXd& a, const VectorXd& b);

/// Whether a likelihood is so much lower than that of a converged fit that searches from there
/// hardly ever lead to a higher one: by half a unit per observation.
bool is_far_below(double rank, const Candidate& best);

bool has_converged(const std::vector<Candidate>& candidates);

/// The highest log-likelihood of the converged fits; -infinity if there are none.
double highest_converged(const std::vector<Candidate>& candidates);

/// The best fit: converged before others, then by rank; of equal ones the first.
/// \param candidates  at least one
const Candidate& best_of(const std::vector<Candidate>& candidates);

/// The best and the other converged fits, from high to low, for reports.
/// \param is_marginal  whether the fits' own likelihood is a marginal one
std::vector<LocalOptimum> optima_of(const Candidate& best,
                                    const std::vector<Candidate>& candidates,
                                    bool is_marginal);

/// All fits, converged or not. The first ones are those of the highest rank; then follow the
/// highest ones of other regions, because the highest start does not always lead to the highest
/// optimum.
/// \param first  number of fits that are ordered only by rank
std::vector<const Candidate*> spread_out(const std::vector<Candidate>& candidates,
                                         std::size_t first);

}  // namespace silvafit::fit
