// SPDX-License-Identifier: MIT
#include "silvafit/tree/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "foliage.hpp"
#include "silvafit/base/error.hpp"
#include "tube.hpp"

namespace silvafit::tree {
namespace {

void check_options(const MeshOptions& options) {
  if (options.stem_sides < 3 || options.branch_sides < 3) {
    throw UsageError("a stem or branch needs at least 3 sides");
  }
  if (!(options.stem_tolerance_m >= 0.0)) {
    throw UsageError("the tolerance of stem sections must not be negative");
  }
}

void check_finite(const MeshPart& part) {
  const auto is_finite = [](float value) { return std::isfinite(value); };
  if (!std::all_of(part.positions.begin(), part.positions.end(), is_finite) ||
      !std::all_of(part.normals.begin(), part.normals.end(), is_finite)) {
    throw GeometryError(std::string("the mesh has a coordinate that is not finite in its ") +
                        part_name(part.kind));
  }
}

}  // namespace

const char* part_name(PartKind kind) {
  switch (kind) {
    case PartKind::kStem:
      return "stem";
    case PartKind::kBranches:
      return "branches";
    case PartKind::kFoliage:
      return "foliage";
  }
  return "";
}

MaterialKind material_of(PartKind kind) {
  return kind == PartKind::kFoliage ? MaterialKind::kLeaf : MaterialKind::kBark;
}

const char* material_name(MaterialKind kind) {
  return kind == MaterialKind::kBark ? "bark" : "leaf";
}

std::size_t Mesh::vertex_count() const {
  std::size_t count = 0;
  for (const MeshPart& part : parts) count += part.vertex_count();
  return count;
}

std::size_t Mesh::triangle_count() const {
  std::size_t count = 0;
  for (const MeshPart& part : parts) count += part.triangle_count();
  return count;
}

Mesh build_mesh(const Skeleton& skeleton,
                const Crown& crown,
                const Preset& preset,
                Random& random,
                const MeshOptions& options) {
  check_options(options);
  MeshPart stem{.kind = PartKind::kStem, .color = preset.bark};
  MeshPart branches{.kind = PartKind::kBranches, .color = preset.bark};
  MeshPart foliage{.kind = PartKind::kFoliage, .color = preset.foliage.outer, .double_sided = true};
  for (const Axis& axis : skeleton.axes) {
    const auto points = skeleton.points_of(axis);
    if (axis.order == 0) {
      add_stem(points, options, stem);
    } else if (points.front().radius_m > 0.0) {
      add_branch(points, axis.order == 1 ? options.branch_sides : 3, crown, branches);
    }
  }
  add_foliage(skeleton, crown, preset.foliage, random, foliage);

  Mesh mesh;
  for (MeshPart* part : {&stem, &branches, &foliage}) {
    check_finite(*part);
    if (!part->indices.empty()) mesh.parts.push_back(std::move(*part));
  }
  return mesh;
}

}  // namespace silvafit::tree
