// SPDX-License-Identifier: MIT
// Curved limbs and single leaves: the mesh of skeletons whose builder places its own leaves.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

enum class LeafForm {
  kFivePolygons,  ///< the outline of a leaf in five polygons that meet at its petiole
  kNeedleFan,     ///< a spray of needles, in few polygons
  kCard,          ///< a rectangle for a picture with transparent ground
  kCrossedCards,  ///< two such rectangles at right angles, full from all sides
};

/// What the leaves of a grade look like.
struct LeafLook {
  LeafForm form = LeafForm::kFivePolygons;
  double aspect = 0.6;  ///< width by length
  /// kFivePolygons: the outline on one side, points (across, along) in shares of length and half
  /// width from the petiole's end to the tip.
  std::vector<std::array<double, 2>> outline{};
  Color color{};
  double color_variation = 0.1;
  std::shared_ptr<const Texture> texture{};  ///< of cards
};

struct SmoothStyle {
  Color bark{};
  std::shared_ptr<const Texture> bark_texture{};
  std::vector<LeafLook> leaves{};  ///< by grade
};

/// Tubes along cubic Hermite curves through the axes' points, in frames that do not twist about
/// the curve, as polygons of the options' numbers of sides; leaves at the skeleton's sites.
///
/// Every edge of stem and limbs is shared by two triangles whose normals point outward. Each limb
/// begins inside the one that bears it. Nothing of limbs and leaves leaves the crown; a leaf that
/// would is moved in.
///
/// Source: Shi, Cheng, Zhang: fast 3D tree simulation with parametric L-systems, sections on
/// skeleton, mesh and leaves; rotation-minimising frames (Wang et al. 2008) instead of Frenet's,
/// which a straight limb does not have.
/// \throws UsageError if an option is out of range
/// \throws GeometryError if a coordinate is not finite
Mesh build_smooth_mesh(const Skeleton& skeleton,
                       const Crown& crown,
                       const SmoothStyle& style,
                       Random& random,
                       const MeshOptions& options = {});

}  // namespace silvafit::tree
