// SPDX-License-Identifier: MIT
// Two neighbors: whether their crowns overlap, where their crown curves meet, and which tree is
// stronger.
#pragma once

#include <optional>

#include "silvafit/tree/crown.hpp"

namespace silvafit::tree {

/// The outline of a crown in the direction of the other stem.
struct FacingCrown {
  const Crown& crown;
  double radius_m = 0.0;  ///< crown radius in the direction of the neighbor
  double ground_m = 0.0;  ///< height of the stem's base; both crowns in the same frame
};

/// Horizontal distance of two stems [m].
double level_distance_m(const Position& first, const Position& second);

/// The crown of a tree in the direction of a neighbor; of two trees at the same position, the one
/// is east of the other.
FacingCrown facing(const Crown& crown, const Position& own, const Position& neighbor);

/// Whether the facing radii add up to more than the distance of the stems.
bool overlap(const FacingCrown& first, const FacingCrown& second, double distance_m);

/// The points where the outlines of two crowns meet in the vertical plane through both stems.
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

/// The two meeting points between the stems; none if the crowns do not overlap, if one passes above
/// the other (or only touches it), or if the top of one crown is inside the other.
///
/// Solves up_1(x) = up_2(d - x) and down_1(x) = down_2(d - x), or one upper with the other's lower
/// curve, for x between the stems. Source: the Chinese fir segment models, eqs. 8 and 9.
std::optional<CrownMeeting> crown_meeting(const FacingCrown& first,
                                          const FacingCrown& second,
                                          double distance_m);

/// Competition of the first tree against the second; below 1 the first is the weaker tree.
struct Competition {
  double horizontal = 1.0;  ///< Ch = Cr1 / Cr2, the facing radii
  double vertical = 1.0;    ///< Cv = (H1 + Z1) / (H2 + Z2), Z above the lower of the two stem bases
  double total = 1.0;       ///< Ct = (Ch + Cv) / 2
};

/// Source: the Chinese fir segment models, eqs. 15 and 16.
Competition competition(const FacingCrown& first, const FacingCrown& second);

/// Whether the first tree is the weaker of the two: Ch Cv < 1, which is equivalent to a Ct smaller
/// than the Ct of the second tree against the first. None if both are equal.
std::optional<bool> first_is_weaker(const Competition& competition);

}  // namespace silvafit::tree
