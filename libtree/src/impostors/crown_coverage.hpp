// SPDX-License-Identifier: MIT
// Opacities of a crown's pictures, so that crossed cards hide as much as the crown.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace silvafit::tree {

/// Width and height of a crown's picture in pixels.
inline constexpr std::size_t kCrownSide = 120;

/// A value in [0, 1] of each pixel, row by row from the upper left.
using PixelValues = std::vector<double>;

/// The picture from above on its pyramid.
struct CrownRoof {
  const PixelValues& opacities;
  double base = 0.0;  ///< height of the edge in the crown, from the crown base (0) to the top (1)
  double rise = 0.0;  ///< of its middle above the edge
};

/// The picture is opaque (at least one half, also between pixels) where more than a limit of a
/// pixel is covered. The limit is chosen so that the picture hides the same area as the mesh.
/// \param covered  the share of each pixel that the mesh covers
PixelValues opacities_from_above(const PixelValues& covered);

/// The same for four crossed cards together with the roof, in the mean over their directions. From
/// most directions several cards are seen, one through the gaps of another; the limit is therefore
/// higher than that of one picture.
/// \param covered  seen from south, southeast and east; the fourth card has the second picture
std::array<PixelValues, 3> opacities_from_sides(const std::array<PixelValues, 3>& covered,
                                                const CrownRoof& roof);

}  // namespace silvafit::tree
