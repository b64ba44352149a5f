// SPDX-License-Identifier: MIT
// Branches at a measured crown radius, and how they avoid a neighbor's.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "silvafit/tree/overlap.hpp"

namespace silvafit::tree {

/// Width of lanes beyond the wood [m].
inline constexpr double kLaneMargin = 0.01;

/// The line with lane radii instead of the wood's.
Lane lane_round(std::span<const SkeletonPoint> wood);

/// A lane or stem that a branch must clear: in the frame of a neighbor with its stem at `stem`.
struct Obstacle {
  const Lane* lane = nullptr;
  Point stem{};
};

/// Distance of a branch's wood from the nearest obstacle's surface [m], or kLaneMargin if it is
/// larger.
double clearance_m(std::span<const SkeletonPoint> wood, std::span<const Obstacle> obstacles);

/// The least changed course of a radius branch that clears the obstacles by kLaneMargin, or the one
/// with the largest clearance.
///
/// The tip stays within 0.4 degrees and 8 mm of the measured radius; the base moves on the stem, so
/// that the angle from the vertical is 30 to 90 degrees; if that is not enough the branch bends.
/// All stays inside the crown.
/// \param on_stem  whether the branch starts on the stem's axis; else its base is fixed
std::vector<SkeletonPoint> turned(std::span<const SkeletonPoint> wood,
                                  bool on_stem,
                                  const Crown& crown,
                                  std::span<const Obstacle> obstacles);

}  // namespace silvafit::tree
