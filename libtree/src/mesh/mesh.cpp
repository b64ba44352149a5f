// SPDX-License-Identifier: MIT
#include "silvafit/tree/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "mesh/foliage.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/segment_tubes.hpp"
#include "mesh/shoot_cards.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/builder.hpp"
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

/// The mean color. Shoots are darkened by their vertices.
Color foliage_color(const Foliage& foliage) {
  constexpr double kInner = 0.25;
  Color color = foliage.outer;
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
  constexpr std::array<const char*, 4> kNames{"stem", "branches", "foliage", "aerial-roots"};
  return kNames.at(static_cast<std::size_t>(kind));
}

const char* material_name(PartKind kind) { return kind == PartKind::kFoliage ? "leaf" : "bark"; }

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

Mesh SegmentBuilder::build_mesh(const Skeleton& skeleton,
                                const Crown& crown,
                                Random& random,
                                const MeshOptions& options) const {
  check_options(options);
  const SegmentTubes tubes(skeleton, crown, options);
  MeshPart stem{.kind = PartKind::kStem};
  MeshPart branches{.kind = PartKind::kBranches};
  MeshPart foliage{.kind = PartKind::kFoliage, .double_sided = true};
  const LeafyShoots& shoots = preset_.leafy_shoots;
  const BarkPaint paint(preset_.bark, skeleton.points_of(skeleton.axes.front()));
  for (MeshPart* part : {&stem, &branches}) paint.dress(*part, options.textured);
  Foliage leaves = preset_.foliage;
  leaves.outer = shoots.color(options.season, leaves.outer);
  if (options.textured) {
    dress_shoots(shoots, preset_.bark, leaves.outer, leaves.color_variation, options, foliage);
  } else {
    foliage.color = foliage_color(leaves);
  }
  {
    const BarkPaint* const bark = options.textured ? &paint : nullptr;
    PartBuilder stem_builder(stem, bark);
    PartBuilder branch_builder(branches, bark);
    tubes.add_to(stem_builder, branch_builder);
    PartBuilder foliage_builder(foliage);
    if (options.textured) {
      const double variation = leaves.color_variation;
      add_shoots(skeleton, crown, shoots, variation, random, options, {}, foliage_builder);
    } else if (shoots.has_leaves(options.season)) {
      if (leaves.kind == FoliageKind::kNeedles) {
        add_needles(skeleton, crown, leaves, options, foliage_builder);
      } else {
        add_leaves(skeleton, crown, leaves, random, options, foliage_builder);
      }
    }
    for (PartBuilder* builder : {&stem_builder, &branch_builder, &foliage_builder}) {
      builder->finish();
    }
  }

  Mesh mesh{.surface_error_m = tubes.surface_error_m()};
  take_parts(mesh, {&stem, &branches, &foliage});
  return mesh;
}

}  // namespace silvafit::tree
