// SPDX-License-Identifier: MIT
// The tolerances and limits of the search for the highest optimum, each with its reason.
#pragma once

#include <cstddef>

namespace silvafit::fit {

// Differences of log-likelihoods, from small to large.

/// Rounding: sums over ten thousand observations keep nine digits after the point, of which the
/// conditional modes take some.
inline constexpr double kRoundedLikelihood = 1e-6;
/// Two searches of one maximum end within this: a step of 0.04 standard errors.
inline constexpr double kSameLikelihood = 1e-3;
/// A log-likelihood that is higher by less is not: linearizations at nearly the same point differ
/// by this much, and nobody would choose a model by it.
inline constexpr double kHigher = 0.05;
/// A linearization is in doubt if its likelihood differs by more from the marginal one: as much as
/// one parameter at the level of 5 % (half the quantile 3.84).
inline constexpr double kDoubtful = 2.0;
/// Very strong evidence by Kass and Raftery (1995, JASA 90: 773-795, section 3.2: twice the
/// difference above 10): more than start values or bounds can ask to overlook.
inline constexpr double kVeryStrong = 5.0;

// Limits of the work.

/// Rounds of the search near the best ends, each after new ends were found.
inline constexpr int kRounds = 3;
/// Ends from which a maximum is searched in a round.
inline constexpr std::size_t kClimbs = 4;
/// Work of the runs from all starts, and again of the search near the best ends, in operations:
/// about a second.
inline constexpr double kOperations = 2e8;
/// The search for maxima stops if the regions of unknown ones are expected to have this share of
/// all starts: after four searches that end at one maximum.
inline constexpr double kUnseen = 0.2;

}  // namespace silvafit::fit
