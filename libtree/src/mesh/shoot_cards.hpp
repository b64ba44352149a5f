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
/// Shoots are along the leafy parts of all branches: branches without other branches are leafy
/// except for their base, others only on their outer part. Their distances follow the width of the
/// crown. The number of shoots follows from the leaf area index; it has a limit, beyond which the
/// shoots are larger.
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

/// The material's color, relative to which vertices darken the shoots.
Color brightest_shoot(const Color& mean, double variation);

/// The number of shoots on a tree, and their length relative to the pictured one.
struct ShootNumber {
  int shoots = 0;
  double scale = 1.0;
};
/// \param leafy_m  length of the branches that bear shoots
ShootNumber number_of_shoots(const LeafyShoots& shoots, const Crown& crown, double leafy_m);

}  // namespace silvafit::tree
