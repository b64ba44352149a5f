// SPDX-License-Identifier: MIT
#include "silvafit/tree/smooth_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/aerial_roots.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/shoot_cards.hpp"
#include "mesh/smooth_leaf.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/smooth_mesh_rings.hpp"
#include "mesh/tube.hpp"
#include "mesh/wood_error.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// The error of a twig that is not drawn is its distance from its start.
double left_out_m(const Limbs& limbs,
                  const WoodRings& finest,
                  const WoodRings& coarse,
                  std::size_t i) {
  const Limb* limb = &limbs.all()[i];
  while (limb->bearer != kNone && coarse.of(limb->bearer).size() < 2) {
    limb = &limbs.all()[limb->bearer];
  }
  const Point base = limbs.knots_of(*limb).front().at;
  const int sides = std::min(finest.sides_of(limbs.all()[i]), coarse.sides_of(limbs.all()[i]));
  double worst = 0.0;
  for (const Ring& ring : finest.of(i)) {
    worst = std::max(worst, length(ring.at - base) + equal_area_corner(sides) * ring.radius_m);
  }
  return worst;
}

double surface_error_m(const Limbs& limbs,
                       const Crown& crown,
                       const WoodRings& rings,
                       const MeshOptions& options) {
  const MeshOptions finest = level_of_detail(0, options);
  if (has_same_wood(finest, options)) return 0.0;
  const WoodRings whole(limbs, crown, finest);
  const auto tube = [&limbs](const WoodRings& of, std::size_t i) -> DrawnTube {
    const int sides = of.sides_of(limbs.all()[i]);
    return {of.of(i), sides, equal_area_corner(sides)};
  };
  return wood_error_m(
      limbs.all().size(),
      [&](std::size_t i) { return tube(whole, i); },
      [&](std::size_t i) { return tube(rings, i); },
      [&](std::size_t i) { return left_out_m(limbs, whole, rings, i); });
}

/// The limbs that are drawn with their bends, and the thinner ones that are drawn straight, so that
/// the wood has about as many triangles as the options allow.
struct ThinnestWood {
  double bent_m = 0.0;  ///< diameter at the base
  double straight_m = 0.0;
};

ThinnestWood thinnest_wood(const Limbs& limbs,
                           const WoodRings& rings,
                           int most,
                           const MeshOptions& options) {
  struct Cost {
    double diameter_m = 0.0;
    int triangles = 0;
  };
  std::vector<Cost> costs;
  for (std::size_t i = 0; i < limbs.all().size(); ++i) {
    const Limb& limb = limbs.all()[i];
    const int count = static_cast<int>(rings.of(i).size());
    if (count < 2) continue;
    costs.push_back(
        {2.0 * limbs.knots_of(limb).front().radius_m, (2 * count - 2) * rings.sides_of(limb) - 2});
  }
  std::stable_sort(costs.begin(), costs.end(), [](const Cost& a, const Cost& b) {
    return a.diameter_m > b.diameter_m;
  });
  constexpr double kBarelyMore = 1.0 + 1e-9;
  constexpr int kOfStraight = 4;  // three sides and a base
  const int most_bent = 3 * most / 4;
  ThinnestWood thinnest{options.thinnest_wood_m, 0.0};
  int sum = 0;
  bool is_bent = true;
  for (const Cost& cost : costs) {
    if (is_bent && sum + cost.triangles > most_bent) {
      is_bent = false;
      thinnest.bent_m = std::max(thinnest.bent_m, kBarelyMore * cost.diameter_m);
    }
    sum += cost.diameter_m >= thinnest.bent_m ? cost.triangles : kOfStraight;
    if (sum > most) {
      thinnest.straight_m = kBarelyMore * cost.diameter_m;
      break;
    }
  }
  return thinnest;
}

void add_wood(const Limbs& limbs,
              const WoodRings& rings,
              const SmoothStyle& style,
              const MeshOptions& options,
              PartBuilder& stem,
              PartBuilder& branches) {
  const std::vector<Point> of_stem = equal_area_corners(options.stem_sides);
  const std::vector<Point> of_branch = equal_area_corners(options.branch_sides);
  const std::vector<Point> of_twig = equal_area_corners(options.twig_sides);
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (std::size_t i = 1; i < limbs.all().size(); ++i) {
    const auto sides = static_cast<std::size_t>(rings.sides_of(limbs.all()[i]));
    vertices += rings.of(i).size() * (sides + 1) + 1;
    triangles += (2 * rings.of(i).size() + 1) * sides;
  }
  branches.reserve(vertices, triangles);
  for (std::size_t i = 0; i < limbs.all().size(); ++i) {
    const Limb& limb = limbs.all()[i];
    if (rings.of(i).size() < 2) continue;
    if (limb.axis != 0) {
      const bool is_thick = rings.sides_of(limb) == options.branch_sides;
      add_tube(
          rings.of(i), is_thick ? of_branch : of_twig, {.textured = options.textured}, branches);
    } else if (options.textured && style.bark.picture->has_roots()) {
      const RootFlare roots(rings.of(i).front().radius_m);
      const TubeLook look{.textured = true, .has_foot = true, .roots = roots};
      add_tube(with_root_sections(rings.of(i), roots), of_stem, look, stem);
    } else {
      add_tube(rings.of(i), of_stem, {.textured = options.textured, .has_foot = true}, stem);
    }
  }
}

}  // namespace

bool shows_shoots(const SmoothStyle& style, const MeshOptions& options) {
  return options.textured && style.shoots && !style.leaves.empty();
}

Mesh build_smooth_mesh(const Skeleton& skeleton,
                       const Crown& crown,
                       const SmoothStyle& style,
                       Random& random,
                       const MeshOptions& options) {
  check_options(options);
  check_looks(skeleton, style);
  check_finite(skeleton);
  const Limbs limbs(skeleton);
  // With textures, thin limbs are straight, or only in the pictures of shoots.
  MeshOptions drawn = options;
  constexpr double kThinnestStraight = 0.4;
  if (options.textured) drawn.thinnest_wood_m *= kThinnestStraight;
  WoodRings rings(limbs, crown, drawn);
  if (options.textured) {
    // Aerial roots take about a fifth of the triangles.
    if (style.aerial_roots) drawn.most_wood = 4 * options.most_wood / 5;
    const ThinnestWood thinnest = thinnest_wood(limbs, rings, drawn.most_wood, options);
    drawn.thinnest_wood_m = std::max(drawn.thinnest_wood_m, thinnest.straight_m);
    rings.omit_thinner(drawn.thinnest_wood_m);
    rings.straighten_thinner(thinnest.bent_m);
  }
  MeshPart stem{.kind = PartKind::kStem};
  MeshPart branches{.kind = PartKind::kBranches};
  MeshPart foliage{
      .kind = PartKind::kFoliage, .color = leaf_material(skeleton, style), .double_sided = true};
  MeshPart roots{.kind = PartKind::kAerialRoots};
  const BarkPaint paint(style.bark, skeleton.points_of(skeleton.axes.front()));
  for (MeshPart* part : {&stem, &branches, &roots}) paint.dress(*part, options.textured);
  const bool has_shoots = shows_shoots(style, options);
  if (options.textured && !style.leaves.empty()) {
    foliage.texture = style.leaves.front().texture;
  }
  const LeafLook look = style.leaves.empty() ? LeafLook{} : style.leaves.front();
  const Color leaf = style.shoots ? style.shoots->color(options.season, look.color) : look.color;
  if (has_shoots) {
    dress_shoots(*style.shoots, style.bark, leaf, look.color_variation, options, foliage);
  } else if (style.shoots && options.season != Season::kSummer) {
    foliage.color = leaf;
  }
  const bool has_leaves = !style.shoots || style.shoots->has_leaves(options.season);
  {
    const BarkPaint* const bark = options.textured ? &paint : nullptr;
    PartBuilder stem_builder(stem, bark);
    PartBuilder branch_builder(branches, bark);
    add_wood(limbs, rings, style, options, stem_builder, branch_builder);
    PartBuilder foliage_builder(foliage);
    if (has_shoots) {
      const auto shift = [&limbs](std::uint32_t axis, Point place) {
        return limbs.moved(axis, place);
      };
      add_shoots(skeleton,
                 crown,
                 *style.shoots,
                 look.color_variation,
                 random,
                 drawn,
                 shift,
                 foliage_builder);
    } else if (has_leaves) {
      add_site_leaves(skeleton, limbs, crown, style, options, foliage_builder);
    }
    PartBuilder root_builder(roots, bark);
    if (style.aerial_roots) {
      add_aerial_roots(skeleton, limbs, *style.aerial_roots, random, options, root_builder);
    }
    for (PartBuilder* builder : {&stem_builder, &branch_builder, &foliage_builder, &root_builder}) {
      builder->finish();
    }
  }
  Mesh mesh{.surface_error_m = surface_error_m(limbs, crown, rings, options)};
  take_parts(mesh, {&stem, &branches, &foliage, &roots});
  return mesh;
}

}  // namespace silvafit::tree
