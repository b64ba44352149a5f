// SPDX-License-Identifier: MIT
// A tree as triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

enum class PartKind { kStem, kBranches, kFoliage };

/// Name of a kind of part in files: stem, branches, foliage.
const char* part_name(PartKind kind);

/// Stem and branches share the bark's material; foliage has the leaves'.
enum class MaterialKind { kBark, kLeaf };

MaterialKind material_of(PartKind kind);
/// Name of a material in files: bark, leaf.
const char* material_name(MaterialKind kind);

/// Triangles of one material, in a frame with y up: x east, z south, the origin where the stem's
/// axis meets the ground.
struct MeshPart {
  PartKind kind = PartKind::kStem;
  Color color{};                       ///< of the material, linear RGB
  bool double_sided = false;           ///< open surfaces that are seen from both sides
  std::vector<float> positions{};      ///< 3 a vertex [m]
  std::vector<float> normals{};        ///< 3 a vertex, of length 1
  std::vector<std::uint8_t> colors{};  ///< 4 a vertex (RGBA, linear), times `color`; or none
  /// 2 a vertex, or none: on bark u runs once around and v along, in turns as long as the girth; on
  /// a leaf u runs across and v from its base to its tip, both in [0, 1]. The origin is the
  /// picture's upper left corner, as in glTF.
  std::vector<float> uvs{};
  /// 4 a vertex, or none: the direction of growing u, of length 1, and the sign of the bitangent.
  std::vector<float> tangents{};
  std::vector<std::uint32_t> indices{};  ///< 3 a triangle, counter-clockwise from outside

  std::size_t vertex_count() const { return positions.size() / 3; }
  std::size_t triangle_count() const { return indices.size() / 3; }
};

/// A tree: stem, branches and foliage, each one part at most. The stem is closed.
struct Mesh {
  std::vector<MeshPart> parts{};

  std::size_t vertex_count() const;
  std::size_t triangle_count() const;
};

struct MeshOptions {
  int stem_sides = 12;
  int branch_sides = 4;
  /// Stem sections are left out where the surface moves by less than this [m]; 0 keeps all.
  double stem_tolerance_m = 0.0005;
};

/// Tubes around the axes, and foliage on the branches' ends and twigs.
///
/// A stem section is a regular polygon with the area of the circle whose diameter the skeleton
/// gives, so that diameters and basal areas on the mesh are those of the tree. Nothing of branches
/// and foliage leaves the crown curve.
/// \throws UsageError if a number of sides is below 3 or the tolerance is negative
/// \throws GeometryError if a coordinate is not finite
Mesh build_mesh(const Skeleton& skeleton,
                const Crown& crown,
                const Preset& preset,
                Random& random,
                const MeshOptions& options = {});

/// What a forester would measure on the finished mesh, from its triangles alone.
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

}  // namespace silvafit::tree
