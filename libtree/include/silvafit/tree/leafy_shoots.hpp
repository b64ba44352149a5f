// SPDX-License-Identifier: MIT
// Foliage as pictures of leafy shoots on crossed cards.
#pragma once

#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {

/// Shoots along the branches of a tree: two crossed cards each.
struct LeafyShoots {
  ShootKind picture = ShootKind::kAlternate;
  /// Length of the pictured shoot, at which its leaves have their true size [m].
  double length_m = 0.6;
  /// Area of the leaves (one side) by the area of the crown's projection. It gives the number of
  /// shoots, unless this would be too many.
  double leaf_area_index = 5.0;
  double angle_deg = 40.0;  ///< between a shoot and its branch
  double lift = 0.3;        ///< how far shoots turn up (or down, if negative), relative to outward
  double cross_deg = 90.0;  ///< between the two cards; the first one faces up
  /// A shoot is a whole twig, from its base to its tip, as a pinna of a fern. The twigs then give
  /// the number and the lengths of the shoots.
  bool is_whole_twig = false;
};

}  // namespace silvafit::tree
