// SPDX-License-Identifier: MIT
#include "silvafit/tree/smooth_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "mesh/jitter.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/mesh_checks.hpp"
#include "mesh/part_builder.hpp"
#include "mesh/shoot_cards.hpp"
#include "mesh/smooth_leaf.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/smooth_mesh_rings.hpp"
#include "mesh/tube.hpp"
#include "mesh/wood_error.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::tree {
namespace {

/// Sections: proportion of the length, radius relative to the root's.
using Section = std::array<double, 2>;
/// A prop, from its foot to its end inside the wood that bears it.
constexpr std::array<Section, 7> kProp{
    {{0.0, 1.9}, {0.04, 1.35}, {0.12, 1.05}, {0.4, 0.95}, {0.7, 1.0}, {0.97, 1.3}, {1.0, 0.0}}};
/// A hanging root, from its limb to its tip.
constexpr std::array<Section, 3> kHanging{{{0.0, 1.0}, {0.5, 0.8}, {1.0, 0.0}}};

/// Where roots leave a limb: at about equal distances along an axis, beyond its first part.
template <typename Use>
void along_limb(std::span<const SkeletonPoint> line, double spacing_m, Jitter& jitter, Use use) {
  constexpr double kBare = 0.25;
  const double whole = line_length_m(line);
  double passed = 0.0;
  double next = kBare * whole + spacing_m * (0.5 + 0.5 * jitter.next());
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double size = length(line[i].at - line[i - 1].at);
    while (next < passed + size) {
      use(between(line[i - 1], line[i], (next - passed) / size));
      next += spacing_m * (1.0 + 0.5 * jitter.next());
    }
    passed += size;
  }
}

class RootWriter {
 public:
  RootWriter(const AerialRoots& roots, const MeshOptions& options, PartBuilder& build)
      : roots_(roots),
        options_(options),
        of_prop_(equal_area_corners(options.branch_sides)),
        of_root_(equal_area_corners(options.twig_sides)),
        build_(build) {}

  /// Draws the same numbers at every level of detail.
  void add(const SkeletonPoint& base, double stem_radius_m, Jitter& jitter) {
    const double kind = 0.5 + 0.5 * jitter.next();
    const double size = 0.5 + 0.5 * jitter.next();
    const double bend = jitter.next();
    constexpr double kThinnestLimb = 0.025;
    constexpr double kLowest = 0.3;
    if (base.radius_m < kThinnestLimb || base.at.z < kLowest) return;
    // Beside the stem a root would grow into it; thin limbs have no old roots.
    constexpr double kFromStem = 3.0;
    constexpr double kThinnestPropped = 0.04;
    const bool is_prop = kind < roots_.props && base.radius_m > kThinnestPropped &&
                         std::hypot(base.at.x, base.at.y) > kFromStem * stem_radius_m;
    constexpr double kOfLimb = 0.7;
    const double thickest = std::min(0.5 * roots_.diameter_m, kOfLimb * base.radius_m);
    if (is_prop) {
      // An old prop thickens from the ground on and becomes thicker than its limb.
      const double radius = (0.4 + 0.6 * size) * 0.5 * roots_.diameter_m;
      prop(base.at, {base.at.x, base.at.y, 0.0}, radius, std::min(radius, thickest), bend);
      merge_into_prop(base.at, radius, size, bend);
    } else if (options_.wood_order >= kAllOrders) {
      constexpr double kThinnest = 0.004;
      const double radius = std::max(kThinnest, (0.1 + 0.15 * size) * thickest);
      hanging(base, radius, (0.1 + 0.45 * size * size) * base.at.z, bend);
    }
  }

 private:
  /// A section of an upright tube.
  static Ring ring(Point at, double radius_m, double along_m, double up) {
    return {.at = at,
            .radius_m = radius_m,
            .tangent = {0.0, 0.0, up},
            .sideways = {1.0, 0.0, 0.0},
            .upward = {0.0, up, 0.0},
            .along_m = along_m};
  }

  /// Thinner roots beside a prop that leave it on their way down: two of three props have them.
  void merge_into_prop(Point top, double radius_m, double size, double bend) {
    const int strands = static_cast<int>(3.0 * size);
    for (int k = 0; k < strands; ++k) {
      const double turn = kTwoPi * (bend + 0.4 * k);
      const double away_m = radius_m * (3.0 + k);
      const Point foot{top.x + away_m * std::sin(turn), top.y + away_m * std::cos(turn), 0.0};
      const double share = 0.85 - 0.3 * k;
      Point fork = top + bow(share, top.z, bend);
      fork.z = share * top.z;
      prop(fork, foot, 0.5 * radius_m, 0.3 * radius_m, -bend);
    }
  }

  /// How far a root bows, which it does not at its ends.
  static Point bow(double share, double length_m, double bend) {
    constexpr double kSway = 0.035;
    const double most_m = kSway * length_m * 4.0 * share * (1.0 - share);
    return {most_m * bend, most_m * (1.0 - std::abs(bend)), 0.0};
  }

  /// From the ground up into the wood at its top.
  void prop(Point top, Point foot, double radius_m, double top_radius_m, double bend) {
    rings_.clear();
    for (const auto& [share, wider] : kProp) {
      const Point at = foot + share * (top - foot) + bow(share, top.z, bend);
      rings_.push_back(
          ring(at, wider * std::lerp(radius_m, top_radius_m, share), share * top.z, 1.0));
    }
    add_tube(rings_, of_prop_, {.textured = options_.textured}, build_);
  }

  /// Down from the limb, ending in a point.
  void hanging(const SkeletonPoint& base, double radius_m, double length_m, double bend) {
    constexpr double kSway = 0.03;
    rings_.clear();
    for (const auto& [share, narrower] : kHanging) {
      Point at = base.at;
      at.x += kSway * length_m * bend * share;
      at.z -= share * length_m;
      rings_.push_back(ring(at, narrower * radius_m, share * length_m, -1.0));
    }
    add_tube(rings_, of_root_, {.textured = options_.textured}, build_);
  }

  const AerialRoots& roots_;
  const MeshOptions& options_;
  std::vector<Point> of_prop_;
  std::vector<Point> of_root_;
  std::vector<Ring> rings_{};
  PartBuilder& build_;
};

/// Adds roots at about equal distances along the outer part of the limbs that are drawn as wood.
///
/// A root starts inside its limb and grows down. Props end at the ground, wider at their foot; the
/// others end above it in a point. Each root is a closed tube.
void add_aerial_roots(const Skeleton& skeleton,
                      const Limbs& limbs,
                      const AerialRoots& roots,
                      Random& random,
                      const MeshOptions& options,
                      PartBuilder& build) {
  RootWriter writer(roots, options, build);
  const double stem_radius_m = skeleton.points.front().radius_m;
  for (std::uint32_t i = 1; i < skeleton.axes.size(); ++i) {
    Jitter jitter(random);
    along_limb(
        skeleton.points_of(skeleton.axes[i]), roots.spacing_m, jitter, [&](SkeletonPoint base) {
          base.at = base.at + limbs.moved(i, base.at);
          writer.add(base, stem_radius_m, jitter);
        });
  }
}

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
