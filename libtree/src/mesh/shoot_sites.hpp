// SPDX-License-Identifier: MIT
// Where the leafy shoots of a skeleton are.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/leafy_shoots.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// A point of an axis and the direction there.
struct OnAxis {
  Point at{};
  Point along{};
};

/// The position of a shoot.
struct ShootSite {
  std::uint32_t axis = 0;
  double along_m = 0.0;
  double rest_m = 0.0;           ///< up to the end of the axis
  double twig_m = 0.0;           ///< length of the twig that the shoot is, if it is a whole one
  bool is_twig = false;          ///< along a twig that is not drawn as wood
  bool is_tip = false;           ///< at the end of a branch
  std::optional<OnAxis> free{};  ///< into a gap of the crown, from a branch or from another shoot
};

/// The sites of a tree's shoots on the finest level of detail, and their length there [m].
struct ShootSites {
  double size_m = 0.0;
  std::vector<ShootSite> sites{};
};

/// Shoots are along the leafy parts of all branches: branches without other branches are leafy
/// except for their base, others only on their outer part. Their distances follow the surface of
/// the crown. None if nothing is leafy.
ShootSites shoot_sites(const Skeleton& skeleton,
                       const Crown& crown,
                       const LeafyShoots& shoots,
                       Random& random,
                       const MeshOptions& options);

/// The number of shoots on a tree, and their length relative to the pictured one.
struct ShootNumber {
  int shoots = 0;
  double scale = 1.0;
};
/// \param leafy_m  length of the branches that bear shoots
ShootNumber number_of_shoots(const LeafyShoots& shoots, const Crown& crown, double leafy_m);

OnAxis on_axis(std::span<const SkeletonPoint> points, double along_m);

}  // namespace silvafit::tree
