// SPDX-License-Identifier: MIT
// The axes that a level of detail draws.
#pragma once

#include <algorithm>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Whether an axis other than the stem is drawn as wood.
inline bool is_drawn(const Axis& axis, const SkeletonPoint& base, const MeshOptions& options) {
  const bool is_in_picture =
      options.textured && axis.order > 1 && 2.0 * base.radius_m < options.thinnest_wood_m;
  return base.radius_m > 0.0 && static_cast<int>(axis.order) <= options.wood_order &&
         !is_in_picture;
}

/// Number of sides of a branch's tube.
inline int sides_of(const SkeletonPoint& base, const MeshOptions& options) {
  return 2.0 * base.radius_m >= options.thick_branch_m ? options.branch_sides : options.twig_sides;
}

/// With textures, bark hides smaller deviations than without.
inline double stem_tolerance_m(const MeshOptions& options) {
  constexpr double kWithBark = 0.002;
  return options.textured ? std::max(options.stem_tolerance_m, kWithBark)
                          : options.stem_tolerance_m;
}
inline double branch_tolerance_m(const MeshOptions& options) {
  constexpr double kWithBark = 0.008;
  return options.textured ? std::max(options.branch_tolerance_m, kWithBark)
                          : options.branch_tolerance_m;
}

/// Whether two levels of detail draw the same wood.
bool has_same_wood(const MeshOptions& a, const MeshOptions& b);

}  // namespace silvafit::tree
