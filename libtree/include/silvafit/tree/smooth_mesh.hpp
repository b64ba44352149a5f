// SPDX-License-Identifier: MIT
// Curved limbs and single leaves: the mesh of skeletons whose builder places its own leaves.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/leafy_shoots.hpp"
#include "silvafit/tree/mesh.hpp"
#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

enum class LeafForm {
  kFivePolygons,  ///< the outline of a leaf in five polygons that meet at its petiole's end
  kNeedleFan,     ///< a spray of needles, in few polygons
  kCard,          ///< a rectangle for an image with transparent background
  kCrossedCards,  ///< two such rectangles at right angles, visible from all sides
};

/// The appearance of the leaves of a grade.
struct LeafLook {
  LeafForm form = LeafForm::kFivePolygons;
  double aspect = 0.6;  ///< width by length
  /// kFivePolygons: the outline on one side from the petiole's end to the tip, without these two:
  /// points (across, along), relative to the half width and to the length. At least three; the
  /// polygons have their corners at the last one, the first one and the middle one of the others.
  /// Or none, for the leaf of a broadleaved tree.
  std::vector<std::array<double, 2>> outline{};
  Color color{};
  double color_variation = 0.1;  ///< with pictures of shoots: how much their brightness varies
  /// Texture of cards; all looks of a tree have the same one, because a mesh has one material for
  /// its foliage.
  std::shared_ptr<const Texture> texture{};
  /// The part of it for this look: left, upper, right and lower edge in [0, 1].
  std::array<double, 4> picture{0.0, 0.0, 1.0, 1.0};
};

/// Roots that grow down from limbs, as of banyans.
struct AerialRoots {
  double spacing_m = 1.0;   ///< between roots along a limb
  double props = 0.3;       ///< proportion that has reached the ground
  double diameter_m = 0.1;  ///< of the thickest prop; a root is thinner than its limb
};

struct SmoothStyle {
  Bark bark{};
  std::vector<LeafLook> leaves{};  ///< by grade
  /// With textures: shoots along the branches, in the color of the first look, instead of a leaf at
  /// each site.
  std::optional<LeafyShoots> shoots{};
  std::optional<AerialRoots> aerial_roots{};
};

/// Whether a mesh with these options shows pictures of shoots instead of the skeleton's leaves.
bool shows_shoots(const SmoothStyle& style, const MeshOptions& options);

/// Tubes along cubic Hermite curves through the axes' points, with frames that do not twist about
/// the curve; leaves at the skeleton's sites.
///
/// Sections are regular polygons with the area of their circle; the options give the number of
/// sides by the thickness of the limb. Sections are those of equal steps along a curve that the
/// options' tolerances need; if these are 0, the bends add half as much to the surface's error as
/// the sections' corners. Every edge of stem and limbs is shared by two triangles whose normals
/// point outward. Each limb begins inside its parent; an axis that starts at the end of its parent
/// with the same thickness continues the parent's tube. Limbs and leaves stay inside the crown; a
/// leaf that would not is moved inward. The stem's section at breast height is horizontal and as
/// large as in the skeleton.
///
/// Axes of a higher order than options.wood_order are omitted, except those that define a
/// measurement of the crown. Axes of radius 0 only bear leaves. With textures, limbs below
/// options.thinnest_wood_m are omitted, and the thinnest of the others if the wood would need more
/// than options.most_wood triangles. Without options.textured cards are
/// drawn as leaves, because their outline is in the image.
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
