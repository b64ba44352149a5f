// SPDX-License-Identifier: MIT
// Leafy shoots on crossed cards along the branches of any skeleton.
#pragma once

#include <functional>

#include "mesh/part_builder.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/leafy_shoots.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Displacement of the drawn wood from a point on an axis of the skeleton.
using WoodShift = std::function<Point(std::uint32_t axis, Point place)>;

/// Adds the shoots of a tree; all of them are inside the crown.
///
/// The number of shoots follows from the leaf area index; it has a limit, beyond which the shoots
/// are larger.
/// \param variation  how much brighter or darker a shoot may be
/// \param shift      or none, if the wood is drawn along the skeleton's lines
void add_shoots(const Skeleton& skeleton,
                const Crown& crown,
                const LeafyShoots& shoots,
                double variation,
                Random& random,
                const MeshOptions& options,
                const WoodShift& shift,
                PartBuilder& build);

/// Gives the part its pictures, and the color relative to which vertices darken the shoots.
/// \param leaf  mean color of the leaves in the season
void dress_shoots(const LeafyShoots& shoots,
                  const Bark& bark,
                  const Color& leaf,
                  double variation,
                  const MeshOptions& options,
                  MeshPart& part);

}  // namespace silvafit::tree
