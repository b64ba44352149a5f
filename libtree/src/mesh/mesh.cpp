// SPDX-License-Identifier: MIT
#include "silvafit/tree/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/foliage.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/shoot_cards.hpp"
#include "mesh/tube.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/texture_library.hpp"

namespace silvafit::tree {
void check_options(const MeshOptions& options) {
  if (options.stem_sides < 3 || options.branch_sides < 3 || options.twig_sides < 3) {
    throw UsageError("a stem or branch needs at least 3 sides");
  }
  if (!(options.stem_tolerance_m >= 0.0 && options.branch_tolerance_m >= 0.0)) {
    throw UsageError("the tolerance of stem sections and branches must not be negative");
  }
  if (!(options.thinnest_wood_m >= 0.0)) throw UsageError("thinnest_wood_m must not be negative");
  if (options.most_wood < 0) throw UsageError("most_wood must not be negative");
  if (options.foliage_per < 1) throw UsageError("foliage_per must be at least 1");
  if (options.wood_order < 1) {
    throw UsageError(
        "wood_order must be at least 1, because first-order branches are always drawn");
  }
}

namespace {

/// Without vertex colors, the material has their mean color. Shoots are darkened by their vertices.
Color foliage_color(const Foliage& foliage, const MeshOptions& options) {
  constexpr double kInner = 0.25;
  Color color = foliage.outer;
  if (options.vertex_colors) return color;
  for (std::size_t i = 0; i < color.size(); ++i) {
    color[i] += kInner * (foliage.inner[i] - color[i]);
  }
  return color;
}

}  // namespace

void take_parts(Mesh& mesh, std::initializer_list<MeshPart*> parts) {
  mesh.parts.reserve(parts.size());
  for (MeshPart* part : parts) {
    check_finite(*part);
    if (!part->indices.empty()) mesh.parts.push_back(std::move(*part));
  }
}

void check_finite(const MeshPart& part) {
  // A finite number times 0 is 0, others are NaN: a sum that the compiler can vectorize.
  const auto is_finite = [](const std::vector<float>& values) {
    float sum = 0.0F;
    for (const float value : values) sum += 0.0F * value;
    return sum == 0.0F;
  };
  if (!is_finite(part.positions) || !is_finite(part.normals)) {
    throw GeometryError(std::string("the mesh has a coordinate that is not finite in its ") +
                        part_name(part.kind));
  }
}

const char* part_name(PartKind kind) {
  switch (kind) {
    case PartKind::kStem:
      return "stem";
    case PartKind::kBranches:
      return "branches";
    case PartKind::kFoliage:
      return "foliage";
    case PartKind::kAerialRoots:
      return "aerial-roots";
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
  MeshPart stem{.kind = PartKind::kStem};
  MeshPart branches{.kind = PartKind::kBranches};
  MeshPart foliage{.kind = PartKind::kFoliage, .double_sided = true};
  const LeafyShoots& shoots = preset.leafy_shoots;
  const BarkPaint paint(preset.bark, skeleton.points_of(skeleton.axes.front()));
  for (MeshPart* part : {&stem, &branches}) paint.dress(*part, options.textured);
  Foliage leaves = preset.foliage;
  leaves.outer = shoots.color(options.season, leaves.outer);
  if (options.textured) {
    dress_shoots(shoots, preset.bark, leaves.outer, leaves.color_variation, options, foliage);
  } else {
    foliage.color = foliage_color(leaves, options);
  }
  {
    const BarkPaint* const bark = options.textured ? &paint : nullptr;
    PartBuilder stem_builder(stem, bark);
    PartBuilder branch_builder(branches, bark);
    BranchTubes tubes(crown, options, branch_builder);
    tubes.reserve(skeleton);
    for (const Axis& axis : skeleton.axes) {
      const auto points = skeleton.points_of(axis);
      if (axis.order == 0) {
        add_stem(points, options, stem_builder);
      } else if (is_drawn(axis, points.front(), options)) {
        tubes.add(points, bearer_radius_m(skeleton, axis));
      }
    }
    PartBuilder foliage_builder(foliage);
    if (options.textured) {
      const double variation = leaves.color_variation;
      add_shoots(skeleton, crown, shoots, variation, random, options, {}, foliage_builder);
    } else if (shoots.has_leaves(options.season)) {
      add_foliage(skeleton, crown, leaves, random, options, foliage_builder);
    }
    for (PartBuilder* builder : {&stem_builder, &branch_builder, &foliage_builder}) {
      builder->finish();
    }
  }

  Mesh mesh{.surface_error_m = surface_error_m(skeleton, crown, options)};
  take_parts(mesh, {&stem, &branches, &foliage});
  return mesh;
}

}  // namespace silvafit::tree
