// SPDX-License-Identifier: MIT
// The distance of a level of detail's wood from that of the finest level.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "mesh/tube.hpp"

namespace silvafit::tree {

/// A tube as a level of detail draws it.
struct DrawnTube {
  std::span<const Ring> rings{};  ///< fewer than two: it is not drawn
  int sides = 3;
  double corner = 1.0;  ///< distance of the polygons' corners from their center, for radius 1
};

using TubeOf = std::function<DrawnTube(std::size_t)>;

/// An upper bound of the distance between the surfaces of two sets of tubes of the same axes, in
/// both directions: that of points with the same relative position between neighboring rings [m].
/// \param left_out  distance of a tube of the finest level that the coarse one does not draw; 0 if
///                  the finest level does not draw it either
double wood_error_m(std::size_t tubes,
                    const TubeOf& finest,
                    const TubeOf& coarse,
                    const std::function<double(std::size_t)>& left_out);

}  // namespace silvafit::tree
