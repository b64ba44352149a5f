// SPDX-License-Identifier: MIT
// Two neighbors: whether their crowns overlap, where their crown curves meet, which one is
// stronger.
#pragma once

#include <optional>

#include "silvafit/tree/crown.hpp"

namespace silvafit::tree {

/// A crown as its neighbor sees it: the outline in the direction of the other stem.
struct FacingCrown {
  const Crown& crown;
  double radius_m = 0.0;  ///< crown radius in the direction of the neighbor
  double ground_m = 0.0;  ///< height of the stem's base; both crowns in one frame
};

/// Level distance of two stems [m].
double level_distance_m(const Position& first, const Position& second);

/// The crown of a tree as a neighbor sees it from its own place; of two trees at one place, the
/// one to the east.
FacingCrown facing(const Crown& crown, const Position& own, const Position& neighbor);

/// Whether the facing radii add up to more than the distance of the stems.
bool overlap(const FacingCrown& first, const FacingCrown& second, double distance_m);

/// Where the outlines of two crowns meet in the upright plane through both stems.
struct CrownMeeting {
  enum class Kind {
    kUpUpAndDownDown,  ///< above: both upper curves; below: both lower curves
    kUpUpAndUpDown,    ///< below: the upper curve of one and the lower curve of the other
  };
  Kind kind = Kind::kUpUpAndDownDown;
  double up_m = 0.0;             ///< height of the upper meeting, in the frame of `ground_m`
  double up_distance_m = 0.0;    ///< its distance from the first stem
  double down_m = 0.0;           ///< height of the lower meeting
  double down_distance_m = 0.0;  ///< its distance from the first stem
};

/// The two meetings between the stems; none where the crowns do not overlap, where one passes above
/// the other (or only grazes it), or where the top of one crown lies inside the other.
///
/// Solves up_1(x) = up_2(d - x) and down_1(x) = down_2(d - x), or one upper with the other's lower
/// curve, for x between the stems. Source: the Chinese fir segment models, eqs. 8 and 9.
std::optional<CrownMeeting> crown_meeting(const FacingCrown& first,
                                          const FacingCrown& second,
                                          double distance_m);

/// How much space the first tree holds against the second; below 1 it is the weaker.
struct Competition {
  double horizontal = 1.0;  ///< Ch = Cr1 / Cr2, the facing radii
  double vertical = 1.0;    ///< Cv = (H1 + Z1) / (H2 + Z2), Z above the lower of the two stem bases
  double total = 1.0;       ///< Ct = (Ch + Cv) / 2
};

/// Source: the Chinese fir segment models, eqs. 15 and 16.
Competition competition(const FacingCrown& first, const FacingCrown& second);

/// Whether the first tree is the weaker of the two: Ch Cv < 1, which is the same as a Ct that is
/// smaller than the Ct of the second tree against the first. None where both are alike.
std::optional<bool> first_is_weaker(const Competition& competition);

}  // namespace silvafit::tree
