// SPDX-License-Identifier: MIT
#include "silvafit/tree/smooth_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/aerial_roots.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/polygon.hpp"
#include "mesh/shoot_cards.hpp"
#include "mesh/smooth_leaf.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/smooth_mesh_tube.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

void check_finite(const Skeleton& skeleton) {
  const auto zero = [](Point p) { return 0.0 * p.x + 0.0 * p.y + 0.0 * p.z; };
  double sum = 0.0;
  for (const SkeletonPoint& point : skeleton.points) sum += zero(point.at) + 0.0 * point.radius_m;
  for (const LeafSite& leaf : skeleton.leaves) {
    sum += zero(leaf.at) + zero(leaf.along) + zero(leaf.facing) + 0.0 * leaf.length_m;
  }
  if (sum != 0.0) throw GeometryError("the skeleton has a coordinate that is not finite");
}

bool has_same_wood(const MeshOptions& a, const MeshOptions& b) {
  return a.stem_sides == b.stem_sides && a.branch_sides == b.branch_sides &&
         a.twig_sides == b.twig_sides && a.thick_branch_m == b.thick_branch_m &&
         a.stem_tolerance_m == b.stem_tolerance_m && a.branch_tolerance_m == b.branch_tolerance_m &&
         a.wood_order == b.wood_order;
}

/// An upper bound of the distance between the surfaces of two sets of rings of the same limbs: that
/// of points with the same relative position between neighboring rings.
class WoodError {
 public:
  WoodError(const Limbs& limbs, const WoodRings& finest, const WoodRings& coarse)
      : limbs_(limbs), finest_(finest), coarse_(coarse) {}

  double bound() {
    double worst = 0.0;
    for (std::size_t i = 0; i < limbs_.all().size(); ++i) {
      const auto whole = finest_.of(i);
      const auto kept = coarse_.of(i);
      if (whole.size() < 2) continue;
      worst = std::max(worst, kept.size() < 2 ? left_out(i) : of_limb(i));
    }
    return worst;
  }

 private:
  double of_limb(std::size_t i) {
    const Limb& limb = limbs_.all()[i];
    const int fine = finest_.sides_of(limb);
    const int rough = coarse_.sides_of(limb);
    corner_ = std::max(equal_area_corner(fine), equal_area_corner(rough));
    gap_ = gap_of(fine, rough);
    const auto whole = finest_.of(i);
    const auto kept = coarse_.of(i);
    return std::max(farthest(whole, kept), farthest(kept, whole));
  }

  double gap_of(int fine, int rough) {
    if (fine == rough) return 0.0;
    if (fine != gap_fine_ || rough != gap_rough_) {
      gap_fine_ = fine;
      gap_rough_ = rough;
      known_gap_ = equal_area_gap(fine, rough);
    }
    return known_gap_;
  }

  double farthest(std::span<const Ring> from, std::span<const Ring> to) const {
    double worst = 0.0;
    std::size_t piece = 0;
    for (const Ring& ring : from) {
      while (piece + 2 < to.size() && to[piece + 1].along_m < ring.along_m) ++piece;
      worst = std::max(worst, error_at(ring, to[piece], to[piece + 1]));
    }
    return worst;
  }

  double error_at(const Ring& ring, const Ring& a, const Ring& b) const {
    const auto [middle, sideways, upward] = offset_between(a, b, ring);
    const double thickest = std::max({ring.radius_m, a.radius_m, b.radius_m});
    // The faces between two inclined rings are not planar, and their diagonals cut the corner: by
    // up to a quarter of the difference of the polygon's sides.
    constexpr double kWarp = 0.25;
    const double turn = length(a.sideways - b.sideways) + length(a.upward - b.upward);
    return length(middle) + corner_ * std::sqrt(dot(sideways, sideways) + dot(upward, upward)) +
           gap_ * thickest + kWarp * corner_ * turn * thickest;
  }

  /// The error of a twig that is not drawn is its distance from its start.
  double left_out(std::size_t i) const {
    const Limb* limb = &limbs_.all()[i];
    while (limb->bearer != kNone && coarse_.of(limb->bearer).size() < 2) {
      limb = &limbs_.all()[limb->bearer];
    }
    const Point base = limbs_.knots_of(*limb).front().at;
    double worst = 0.0;
    for (const Ring& ring : finest_.of(i)) {
      worst = std::max(worst, length(ring.at - base) + corner_ * ring.radius_m);
    }
    return worst;
  }

  const Limbs& limbs_;
  const WoodRings& finest_;
  const WoodRings& coarse_;
  double corner_ = 1.0;
  double gap_ = 0.0;
  int gap_fine_ = 0;
  int gap_rough_ = 0;
  double known_gap_ = 0.0;
};

double wood_error_m(const Limbs& limbs,
                    const Crown& crown,
                    const WoodRings& rings,
                    const MeshOptions& options) {
  const MeshOptions finest = level_of_detail(0, options);
  if (has_same_wood(finest, options)) return 0.0;
  return WoodError(limbs, WoodRings(limbs, crown, finest), rings).bound();
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

void add_leaves(const Skeleton& skeleton,
                const Limbs& limbs,
                Random& random,
                const MeshOptions& options,
                const SmoothStyle& style,
                LeafWriter& writer) {
  const double scale = std::sqrt(static_cast<double>(options.foliage_per));
  for (std::size_t i = 0; i < skeleton.leaves.size(); ++i) {
    LeafSite site = skeleton.leaves[i];
    // Drawn for all of them, so that the levels of detail agree on common ones.
    const double shade = 1.0 - style.leaves[site.grade].color_variation * random.uniform();
    if (i % static_cast<std::size_t>(options.foliage_per) != 0) continue;
    site.at = site.at + limbs.moved(site.axis, site.at);
    writer.add(site, scale, shade);
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
  MeshPart foliage{.kind = PartKind::kFoliage,
                   .color = leaf_material(skeleton, style, options.vertex_colors),
                   .double_sided = true};
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
      LeafWriter writer(crown, style, options, foliage.color, foliage_builder);
      writer.reserve(skeleton);
      add_leaves(skeleton, limbs, random, options, style, writer);
    }
    PartBuilder root_builder(roots, bark);
    if (style.aerial_roots) {
      add_aerial_roots(skeleton, limbs, *style.aerial_roots, random, options, root_builder);
    }
    for (PartBuilder* builder : {&stem_builder, &branch_builder, &foliage_builder, &root_builder}) {
      builder->finish();
    }
  }
  Mesh mesh{.surface_error_m = wood_error_m(limbs, crown, rings, options)};
  take_parts(mesh, {&stem, &branches, &foliage, &roots});
  return mesh;
}

}  // namespace silvafit::tree
