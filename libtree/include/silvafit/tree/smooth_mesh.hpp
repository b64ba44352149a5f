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
  kFivePolygons,  ///< the outline of a leaf in five polygons that meet at its petiole's end
  kNeedleFan,     ///< a spray of needles, in few polygons
  kCard,          ///< a rectangle for a picture with transparent ground
  kCrossedCards,  ///< two such rectangles at right angles, full from all sides
};

/// What the leaves of a grade look like.
struct LeafLook {
  LeafForm form = LeafForm::kFivePolygons;
  double aspect = 0.6;  ///< width by length
  /// kFivePolygons: the outline on one side from the petiole's end to the tip, without these two:
  /// points (across, along), shares of the half width and of the length. At least three; the
  /// polygons have their corners at the last one, the first one and the middle one of the others.
  /// Or none, for the leaf of a broadleaved tree.
  std::vector<std::array<double, 2>> outline{};
  Color color{};
  double color_variation = 0.1;  ///< how much darker than that the darkest leaf is, as a share
  /// Laid over cards; all looks of a tree have the same one, as one mesh has one material for its
  /// foliage.
  std::shared_ptr<const Texture> texture{};
  /// The part of it that is of this look: left, upper, right and lower edge in [0, 1].
  std::array<double, 4> picture{0.0, 0.0, 1.0, 1.0};
};

struct SmoothStyle {
  Color bark{};
  std::shared_ptr<const Texture> bark_texture{};
  std::vector<LeafLook> leaves{};  ///< by grade
};

/// Tubes along cubic Hermite curves through the axes' points, in frames that do not turn about
/// the curve; leaves at the skeleton's sites.
///
/// Sections are regular polygons with the area of the circle they stand for, of as many sides as
/// the options say for their limb's thickness. They stand at those of a curve's equal steps that
/// the options' tolerances need; where these are 0, the bends add half as much to the surface's
/// error as the sections' corners. Every edge of stem and limbs is shared by two triangles whose
/// normals point outward. Each limb begins inside the one that bears it; an axis that starts at the
/// end of its parent and is as thick goes on as one tube with it. Nothing of limbs and leaves
/// leaves the crown; a leaf that would is moved in. The stem's section at breast height is level
/// and as large as the skeleton says.
///
/// Axes of a higher order than options.wood_order are left out, except those that a measurement of
/// the crown ends on. Axes of radius 0 bear leaves only. Without options.textured cards are drawn
/// as leaves, since their outline is in the picture.
///
/// Source: Shi, Cheng, Zhang: fast 3D tree simulation with parametric L-systems, sections on
/// skeleton, mesh and leaves; rotation-minimizing frames (Wang et al. 2008) instead of Frenet's,
/// which a straight limb does not have.
/// \throws UsageError if an option is out of range, a leaf's grade has no look, looks have
/// different textures, or an outline has fewer than three points
/// \throws GeometryError if a coordinate is not finite
Mesh build_smooth_mesh(const Skeleton& skeleton,
                       const Crown& crown,
                       const SmoothStyle& style,
                       Random& random,
                       const MeshOptions& options = {});

}  // namespace silvafit::tree
