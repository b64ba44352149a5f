// SPDX-License-Identifier: MIT
// The ground of a stand: a surface through the feet of its stems.
#pragma once

#include <cstddef>
#include <span>

#include "silvafit/data/raster.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// The most points of a terrain in the ground: two triangles each, as many as a detailed tree has.
inline constexpr std::size_t kMostGroundPoints = 40000;

/// Triangles through all stem bases (Delaunay in plan), in a frame with y up around `origin`.
///
/// Stems nearer than a centimeter to each other share a point. Beyond the outermost stems the
/// ground is as high as the base of the nearest stem. Unknown elevations are 0 in `z_m`, so that
/// the ground is level.
/// \param margin_m  how far it reaches beyond the outermost stems
/// \param terrain   whose cells there are points of the ground, too, every second, third ... one if
///   they are more than kMostGroundPoints; null: none
/// \throws GeometryError if there is no stem, or the stems lie more than 10,000 km from the origin
MeshPart ground_mesh(std::span<const Position> stems,
                     const Position& origin,
                     double margin_m = 2.0,
                     const data::Raster* terrain = nullptr);

}  // namespace silvafit::tree
