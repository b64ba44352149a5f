// SPDX-License-Identifier: MIT
// The tolerances and limits of the search for the highest optimum, each with its reason.
#pragma once

#include <cstddef>
#include <string_view>

namespace silvafit::fit {

/// A log-likelihood that is higher by less is not: linearizations at nearly the same point, and
/// the ends of two searches of one maximum, differ by this much. Nobody would choose a model by it.
inline constexpr double kHigher = 0.05;
/// A linearization is in doubt if its likelihood differs by more from the marginal one.
inline constexpr double kDoubtful = 2.0;
/// Rounds of climbing after new ends were found.
inline constexpr int kRounds = 3;
/// Ends from which a maximum is searched in a round.
inline constexpr std::size_t kClimbs = 4;
/// Work of the search from all starts, and again of that near the best ends, in operations.
inline constexpr double kOperations = 2e8;
/// A search stops if the regions that lead to unknown maxima are expected to have this share of all
/// starts; see LocalOptima::is_complete.
inline constexpr double kUnseen = 0.2;

inline constexpr std::string_view kMaximumOrigin = "maximum of the marginal likelihood";

}  // namespace silvafit::fit
