// SPDX-License-Identifier: MIT
// A tree as a triangle mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::tree {

/// Aerial roots hang from the limbs, some of them down to the ground. They are no part of the crown
/// or of the stem, and no measurement includes them.
enum class PartKind { kStem, kBranches, kFoliage, kAerialRoots };

/// Name of a kind of part in files: stem, branches, foliage, aerial-roots.
const char* part_name(PartKind kind);

/// Material of a kind of part in files: leaf for foliage, bark for all others.
const char* material_name(PartKind kind);

/// Triangles of one material, in a frame with y up: x east, z south; the origin is where the stem's
/// axis meets the ground.
struct MeshPart {
  PartKind kind = PartKind::kStem;
  /// Distinguishes materials of the same kind and preset: PRESET-VARIANT-leaf in files; or empty.
  std::string variant{};
  Color color{};                       ///< of the material, linear RGB
  bool double_sided = false;           ///< open surfaces that are visible from both sides
  std::vector<float> positions{};      ///< 3 per vertex [m]
  std::vector<float> normals{};        ///< 3 per vertex, of length 1
  std::vector<std::uint8_t> colors{};  ///< 4 per vertex (RGBA, linear), times `color`; or none
  /// 2 per vertex, or none: on bark u runs around and v along, both in widths of the picture, which
  /// goes around a whole number of times; on a leaf u runs across and v from its base to its tip,
  /// both in [0, 1]. The origin is the image's upper left corner, as in glTF.
  std::vector<float> uvs{};
  /// 4 per vertex, or none: the direction of increasing u, of length 1, and the bitangent sign.
  std::vector<float> tangents{};
  std::vector<std::uint32_t> indices{};  ///< 3 per triangle, counterclockwise from outside
  /// Placed on the part by its UVs and multiplied with the color, or null; transparent pixels are
  /// not drawn.
  std::shared_ptr<const Texture> texture{};
  /// Normals relative to the surface as in glTF, placed like the texture, or null.
  std::shared_ptr<const Texture> normal_texture{};

  std::size_t vertex_count() const { return positions.size() / 3; }
  std::size_t triangle_count() const { return indices.size() / 3; }
};

/// A tree: stem, branches, foliage and aerial roots, each at most one part. The stem is closed.
struct Mesh {
  std::vector<MeshPart> parts{};
  /// Upper bound of the distance between the surfaces of stem and branches of this mesh and of the
  /// finest one of the same skeleton, in both directions [m]; 0 for the finest.
  double surface_error_m = 0.0;

  std::size_t vertex_count() const;
  std::size_t triangle_count() const;
};

/// Wood of every order, in MeshOptions::wood_order.
inline constexpr int kAllOrders = 1 << 20;

/// Options for meshing a skeleton. The defaults are the finest level of detail.
struct MeshOptions {
  int stem_sides = 12;
  int branch_sides = 6;  ///< for branches at least as thick at their base as thick_branch_m
  int twig_sides = 3;    ///< for all others
  double thick_branch_m = 0.06;
  /// Stem sections are omitted if this changes the radius by less than this value and the axis by
  /// less than five times this value [m]; 0 keeps all. With textures it is at least 2 mm, and the
  /// axis of a smooth mesh may shift by fifteen times the value.
  double stem_tolerance_m = 0.0005;
  /// Bends of branches are omitted if the surface moves by less than this [m]; 0 keeps all.
  double branch_tolerance_m = 0.0;
  int wood_order = kAllOrders;  ///< highest order of branches that are drawn as wood
  int foliage_per = 1;          ///< one of this number of sprays or tufts is drawn, larger

  /// Each branch's tube is closed at its base, which is inside its parent: every edge of stem and
  /// branches then belongs to exactly two triangles.
  bool closed_branches = false;
  /// Textures of bark, and leafy shoots on crossed cards (leafy_shoots.hpp) instead of single
  /// leaves.
  bool textured = false;
  /// With textures: thinner branches are in the pictures of shoots and not drawn, except those that
  /// define a measurement of the crown [m]. Smooth meshes draw them down to two fifths of this, as
  /// straight lines.
  double thinnest_wood_m = 0.014;
  /// With textures: triangles of stem and limbs of smooth meshes, as far as measurements allow.
  int most_wood = 5000;
  Season season = Season::kSummer;  ///< deciduous trees are bare in winter
};

/// Levels of detail are numbered from 0, the finest.
inline constexpr int kLevelsOfDetail = 4;

/// Sides, sections, twigs and foliage of a level; options that do not depend on the level are
/// those of `base`.
/// \throws UsageError if there is no such level
MeshOptions level_of_detail(int level, const MeshOptions& base = {});

/// Measurements of the finished mesh, from its triangles only.
struct Measurements {
  double h_m = 0.0;     ///< height of the highest vertex
  double hcb_m = 0.0;   ///< height of the lowest vertex of branches and foliage
  double dbh_cm = 0.0;  ///< diameter of the circle with the area of the stem's section at 1.3 m
  CrownRadii radii{};   ///< farthest vertex of branches and foliage within half a degree
  std::size_t vertices = 0;
  std::size_t triangles = 0;
};
/// \throws GeometryError if the mesh has no stem at 1.3 m or no crown
Measurements measure(const Mesh& mesh);
/// The same of dead wood: without a stem at 1.3 m the DBH is 0, without branches hcb is the height.
Measurements measure_dead_wood(const Mesh& mesh);

/// Diameters of the circles with the areas of the stem's sections at these heights [cm]; 0 if
/// there is no stem.
/// \param heights_m  in any order
std::vector<double> stem_diameters_cm(const Mesh& mesh, std::span<const double> heights_m);

}  // namespace silvafit::tree
