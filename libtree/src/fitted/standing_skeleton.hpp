// SPDX-License-Identifier: MIT
// A freely grown skeleton: with its stem made upright and straight, or as it is.
#pragma once

#include <span>
#include <vector>

#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// A skeleton in its original units, around a stem that is the z axis from 0 up: at each height
/// everything is shifted sideways by the stem's distance from the axis.
struct StandingSkeleton {
  /// The stem and its continuation: if it ends in a fork, the limb that rises highest.
  Skeleton skeleton{};
  std::vector<SkeletonPoint> course{};  ///< of the stem before it was straightened, increasing
  double top = 0.0;                     ///< of the stem and all branches
  double first_base = 0.0;              ///< lowest point on the stem with a branch
  double lowest = 0.0;                  ///< of branches and leaves
};

/// \throws GeometryError if a coordinate is not finite, or the skeleton has no stem or no branch
void check_grown(const Skeleton& grown);

/// \throws GeometryError if a coordinate is not finite, there is no stem that rises or no branch
StandingSkeleton standing(const Skeleton& grown);

/// The vector `v` after the smallest rotation that turns direction `from` into direction `to`.
Point turned_with(Point v, Point from, Point to);

/// The same skeleton with the stem's base at the origin and the highest point of its axes at a
/// height; all directions and ratios of lengths and radii are kept.
/// \throws GeometryError if a coordinate is not finite, there is no branch, or nothing rises above
/// the stem's base
Skeleton scaled_to_height(Skeleton grown, double h_m);

/// The extent of a skeleton: height, lowest point of the branches, and radii in the four
/// directions.
TreeShape shape_of(const Skeleton& skeleton);

}  // namespace silvafit::tree
