// SPDX-License-Identifier: MIT
#include "mesh/shoot_cards.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "mesh/shoot_sites.hpp"
#include "silvafit/tree/builder.hpp"
#include "test_support/fitted_test_support.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

constexpr std::array kBuilders{
    BuilderKind::kSegment, BuilderKind::kLsystem, BuilderKind::kIfs, BuilderKind::kBamboo};

const BuilderCatalogue& all_builders() {
  static const BuilderCatalogue catalogue = BuilderCatalogue::load(test::source_file("models"));
  return catalogue;
}

Morphology tall_tree(double cw_m) {
  return {.plot = "1", .tree = "1", .dbh_cm = 30, .h_m = 18, .hcb_m = 5, .cw_m = cw_m};
}

double area_m2(const MeshPart& part) {
  double sum = 0.0;
  for (std::size_t i = 0; i < part.triangle_count(); ++i) {
    const auto [a, b, c] = test::triangle_of(part, i);
    sum += 0.5 * length(cross(b - a, c - a));
  }
  return sum;
}

/// Where the shoots of a skeleton start: the middle of the lower edge of the first of two cards.
std::vector<Point> shoot_bases(const Skeleton& skeleton,
                               const Crown& crown,
                               const LeafyShoots& shoots) {
  MeshPart foliage{.kind = PartKind::kFoliage};
  PartBuilder build(foliage);
  Random random(1);
  add_shoots(skeleton, crown, shoots, 0.1, random, {.textured = true}, {}, build);
  build.finish();
  std::vector<Point> bases;
  for (std::size_t i = 0; i < foliage.vertex_count(); i += 12) {
    bases.push_back(0.5 * (test::vertex_of(foliage, i) + test::vertex_of(foliage, i + 1)));
  }
  return bases;
}

}  // namespace

TEST_CASE("the shoots of a tree have its leaf area") {
  for (const char* name : {"generic-broadleaf", "schima-superba", "cunninghamia-lanceolata"}) {
    const Preset& preset = test::shipped_presets().named(name);
    for (const double cw_m : {3.0, 4.0, 6.0, 8.0}) {
      const SceneTree grown = grow_tree(tall_tree(cw_m), preset, {.mesh = {.textured = true}});
      const MeshPart& foliage = grown.mesh.parts.back();
      REQUIRE(foliage.kind == PartKind::kFoliage);
      const double covered = preset.leafy_shoots.picture->leafy().covered;
      const double leaf_area_index =
          covered * area_m2(foliage) / (0.25 * std::numbers::pi * cw_m * cw_m);
      INFO(name << ' ' << cw_m << ": " << foliage.triangle_count() / 8 << " shoots");
      // More in crowns wider than 5 m, or more than 1.8 times as long as wide, and filled ones.
      // Shoots at the crown's surface are smaller, so that they stay inside; the others are larger,
      // but by no more than three tenths.
      const double depth = std::clamp(std::max(cw_m / 5.0, 13.0 / cw_m / 1.8), 1.0, 1.8);
      const double filled = preset.leafy_shoots.reach > 0.0 ? 1.5 : 1.0;
      const double wanted = filled * depth * preset.leafy_shoots.leaf_area_index;
      CHECK(leaf_area_index <= 1.1 * wanted);
      CHECK(leaf_area_index >= 0.7 * wanted);
    }
  }
}

TEST_CASE("coarser levels of detail have the leaf area of the finest one") {
  for (const char* name : {"generic-broadleaf", "schima-superba", "cunninghamia-lanceolata"}) {
    const Preset& preset = test::shipped_presets().named(name);
    for (const double cw_m : {3.0, 4.0, 6.0, 8.0}) {
      const auto area_at = [&](int level) {
        const MeshOptions mesh = level_of_detail(level, {.textured = true});
        return area_m2(grow_tree(tall_tree(cw_m), preset, {.mesh = mesh}).mesh.parts.back());
      };
      const double finest = area_at(0);
      for (int level = 1; level < kLevelsOfDetail; ++level) {
        INFO(name << ' ' << cw_m << " m, level " << level);
        // Half a shoot may be missing at the end, of 37 or more.
        CHECK(area_at(level) == Approx(finest).epsilon(0.014));
      }
    }
  }
}

TEST_CASE("leaves have the length in their picture to 3 tenths, unless the crown is very small") {
  const Preset& preset = test::shipped_presets().named("schima-superba");
  const auto number = [&](double cw_m) {
    const Crown crown(complete(tall_tree(cw_m), preset.relative_hc, ""), preset.crown_index);
    return number_of_shoots(preset.leafy_shoots, crown, 1e6);
  };
  // The narrower a crown is, the more shoots become smaller at its surface.
  CHECK(number(8.0).scale == Approx(1.0).margin(0.1));
  CHECK(number(5.0).scale > number(8.0).scale);
  CHECK(number(5.0).scale <= 1.3);
  // In a crown of 1 m shoots have a fifth to a quarter of that; one of 30 m would need too many.
  CHECK(number(1.0).scale * preset.leafy_shoots.length_m == Approx(0.225).margin(0.025));
  CHECK(number(30.0).scale > 1.0);
  CHECK(number(30.0).scale <= 1.3);
  CHECK(number(30.0).shoots <= 1700);
}

TEST_CASE("a limb bears shoots from its last twig to its tip") {
  // A limb to the east, whose only twigs are near the stem, in a crown with many other branches.
  test::HandMade tree;
  tree.axis(0, {{{0, 0, 0}, 0.1}, {{0, 0, 18}, 0.0}});
  const auto limb = tree.axis(0, {{{0, 0, 9}, 0.05}, {{5, 0, 10}, 0.0}});
  for (const double x : {1.0, 2.0}) {
    tree.axis(limb, {{{x, 0, 9 + 0.2 * x}, 0.01}, {{x, 0.8, 9 + 0.2 * x}, 0.0}});
  }
  for (int i = 0; i < 60; ++i) {
    const double z = 6.0 + 0.15 * i;
    tree.axis(0, {{{0, 0, z}, 0.02}, {{0, 2, z}, 0.0}});
  }
  const Crown crown(complete(tall_tree(12.0), 0.4, "test"), {});
  const LeafyShoots shoots = test::shoots_of(0.5, 1.0);
  std::vector<double> along;
  for (const Point base : shoot_bases(tree.take(), crown, shoots)) {
    if (std::abs(base.y) < 0.3 && std::abs(base.z - 9.0 - 0.2 * base.x) < 0.3) {
      along.push_back(base.x);
    }
  }
  std::sort(along.begin(), along.end());
  REQUIRE(along.size() >= 8);
  // The last shoot ends at the tip; shoots overlap along the outer part of the limb.
  CHECK(along.back() > 5.0 - 0.6);
  for (std::size_t i = 1; i < along.size(); ++i) {
    if (along[i - 1] > 2.0) CHECK(along[i] - along[i - 1] < 0.5);
  }
}

TEST_CASE("the shoots of a layer follow the crown's surface, not the number of its branches") {
  // Twice as many branches in the lower half of the crown as in the upper one.
  test::HandMade tree;
  tree.axis(0, {{{0, 0, 0}, 0.1}, {{0, 0, 18}, 0.0}});
  const Crown crown(complete(tall_tree(8.0), 0.5, "test"), {});
  REQUIRE(crown.hc_m() == 11.5);
  for (int i = 0; i < 120; ++i) {
    const double share = (i + 0.5) / 120;
    if (share > 0.5 && i % 2 == 0) continue;
    const double z = 5.0 + 13.0 * share;
    const double length = 0.9 * 4.0 * crown.relative_width(z);
    const double azimuth = 2.4 * i;
    tree.axis(
        0, {{{0, 0, z}, 0.01}, {{length * std::cos(azimuth), length * std::sin(azimuth), z}, 0.0}});
  }
  const LeafyShoots shoots = test::shoots_of(0.4, 5.0);
  const std::vector<Point> bases = shoot_bases(tree.take(), crown, shoots);
  REQUIRE(bases.size() > 800);
  const auto upper =
      std::count_if(bases.begin(), bases.end(), [](Point base) { return base.z > 11.5; });
  // The crown is symmetrical about its middle. One shoot at the end of each branch is additional.
  CHECK(static_cast<double>(upper) / static_cast<double>(bases.size()) == Approx(0.5).margin(0.03));
}

TEST_CASE("a shoot that is a whole twig starts at its branch and has the twig's length") {
  // A stem with a branch to the east, which bears two twigs.
  test::HandMade tree;
  tree.axis(0, {{{0, 0, 0}, 0.1}, {{0, 0, 10}, 0.0}});
  const auto branch = tree.axis(0, {{{0, 0, 9}, 0.03}, {{3, 0, 9}, 0.0}});
  tree.axis(branch, {{{1, 0, 9}, 0.005}, {{1, 0.8, 9}, 0.0}});
  tree.axis(branch, {{{2, 0, 9}, 0.005}, {{2, -0.5, 9}, 0.0}});
  const TreeShape shape = complete(tall_tree(12.0), 0.35, "test");
  const Crown crown(shape, {});
  LeafyShoots fronds = test::shoots_of(0.6, 5.0);
  fronds.lift = 0.0;
  fronds.cross_deg = 20.0;
  fronds.is_whole_twig = true;
  MeshPart foliage{.kind = PartKind::kFoliage};
  PartBuilder build(foliage);
  Random random(1);
  add_shoots(tree.take(), crown, fronds, 0.1, random, {.textured = true}, {}, build);
  build.finish();
  // Two cards for each twig, and for the top of the stem.
  REQUIRE(foliage.triangle_count() == 24);
  for (std::size_t card = 0; card < 4; ++card) {
    // The first two corners are those at the base.
    const Point base =
        0.5 * (test::vertex_of(foliage, 6 * card) + test::vertex_of(foliage, 6 * card + 1));
    const Point end =
        0.5 * (test::vertex_of(foliage, 6 * card + 4) + test::vertex_of(foliage, 6 * card + 5));
    const bool is_first = card < 2;
    CHECK(length(base - Point{is_first ? 1.0 : 2.0, 0.0, 9.0}) < 1e-5);
    CHECK(length(end - base) == Approx(is_first ? 0.8 : 0.5).epsilon(1e-5));
  }
}

TEST_CASE("trees of every preset with pictures have at most some twenty thousand triangles") {
  for (const BuilderKind kind : kBuilders) {
    for (const Builder* builder : all_builders().of(kind)) {
      for (const double cw_m : {3.0, 7.0, 14.0}) {
        const SceneTree grown = grow_tree(tall_tree(cw_m), *builder, {.mesh = {.textured = true}});
        INFO(builder->name() << ' ' << cw_m << ": " << grown.mesh.triangle_count());
        CHECK(grown.mesh.triangle_count() <= 20000);
      }
    }
  }
}

TEST_CASE("textured meshes of any tree of any builder have its measurements and crown") {
  Random random(52);
  for (const BuilderKind kind : kBuilders) {
    for (const Builder* builder : all_builders().of(kind)) {
      for (int i = 0; i < 4; ++i) {
        const Morphology tree = test::random_morphology(random, i);
        const MeshOptions options = level_of_detail(i % kLevelsOfDetail, {.textured = true});
        const SceneTree grown = grow_tree(tree, *builder, {.mesh = options});
        test::check_mesh_measurements(tree, grown);
        const Crown crown(builder->shape_of(tree), builder->preset().crown_index);
        double outside = 0.0;
        for (const MeshPart& part : grown.mesh.parts) {
          REQUIRE(part.uvs.size() == 2 * part.vertex_count());
          REQUIRE(part.tangents.size() == 4 * part.vertex_count());
          if (part.kind != PartKind::kFoliage) continue;
          for (std::size_t v = 0; v < part.vertex_count(); ++v) {
            outside = std::max(outside, crown.excess_m(test::vertex_of(part, v)));
          }
        }
        INFO(builder->name() << ' ' << i);
        CHECK(outside < 0.001);
      }
    }
  }
}

TEST_CASE("leaves deep in the crown are darker") {
  const SceneTree grown = grow_tree(tall_tree(7.0),
                                    test::shipped_presets().named("generic-broadleaf"),
                                    {.mesh = {.textured = true}});
  const MeshPart& foliage = grown.mesh.parts.back();
  double inside = 0.0;
  double outside = 0.0;
  std::size_t inner = 0;
  std::size_t outer = 0;
  for (std::size_t v = 0; v < foliage.vertex_count(); ++v) {
    const Point at = test::vertex_of(foliage, v);
    const double from_axis = std::hypot(at.x, at.y);
    if (at.z < 8.0 || at.z > 12.0) continue;
    if (from_axis < 1.2) {
      inside += foliage.colors[4 * v];
      ++inner;
    } else if (from_axis > 2.8) {
      outside += foliage.colors[4 * v];
      ++outer;
    }
  }
  REQUIRE(inner > 10);
  REQUIRE(outer > 10);
  CHECK(inside / static_cast<double>(inner) < 0.85 * outside / static_cast<double>(outer));
}

TEST_CASE("the limbs of a shrub at the measured radii are leafy up to their tips") {
  const Builder& shrub = all_builders().named(BuilderKind::kLsystem, "shrub");
  double sum_m = 0.0;
  double farthest_m = 0.0;
  int tips = 0;
  for (int i = 0; i < 12; ++i) {
    const Morphology tree{.plot = "1",
                          .tree = std::to_string(i),
                          .dbh_cm = 6,
                          .h_m = 3,
                          .hcb_m = 0.15 * (i % 3),
                          .cw_m = 3.4};
    const SceneTree grown = grow_tree(tree, shrub, {.mesh = {.textured = true}});
    const MeshPart& foliage = grown.mesh.parts.back();
    const double hc_m = shrub.shape_of(tree).hc_m;
    for (const Point tip :
         {Point{1.7, 0, hc_m}, {-1.7, 0, hc_m}, {0, 1.7, hc_m}, {0, -1.7, hc_m}}) {
      double nearest_m = 10.0;
      for (std::size_t t = 0; t < foliage.triangle_count(); ++t) {
        nearest_m =
            std::min(nearest_m, test::distance_to_triangle(tip, test::triangle_of(foliage, t)));
      }
      sum_m += nearest_m;
      farthest_m = std::max(farthest_m, nearest_m);
      ++tips;
    }
  }
  // Shoots have 40 cm, their leaves 6 cm. Before there were shoots for tips: 9 and 21 cm.
  CHECK(sum_m / tips < 0.06);
  CHECK(farthest_m < 0.15);
}

namespace {

/// A shoot from its base to its tip, by the first of its two cards.
struct Drawn {
  Point base{};
  Point tip{};
  double size_m = 0.0;
};

std::vector<Drawn> drawn_shoots(const MeshPart& foliage) {
  std::vector<Drawn> shoots;
  for (std::size_t i = 0; i + 11 < foliage.vertex_count(); i += 12) {
    const auto corner = [&](std::size_t k) { return test::vertex_of(foliage, i + k); };
    const Point base = 0.5 * (corner(0) + corner(1));
    const Point tip = 0.5 * (corner(4) + corner(5));
    shoots.push_back({base, tip, length(tip - base)});
  }
  return shoots;
}

double distance_to_line(Point p, const Drawn& shoot) {
  const Point chord = shoot.tip - shoot.base;
  const double squared = std::max(dot(chord, chord), 1e-12);
  const double share = std::clamp(dot(p - shoot.base, chord) / squared, 0.0, 1.0);
  return length(p - (shoot.base + share * chord));
}

/// Points of the stem and the branches at most 5 cm apart.
std::vector<Point> points_of_wood(const Mesh& mesh) {
  std::vector<Point> points;
  for (const MeshPart& part : mesh.parts) {
    if (part.kind != PartKind::kStem && part.kind != PartKind::kBranches) continue;
    for (std::size_t t = 0; t < part.triangle_count(); ++t) {
      const auto [a, b, c] = test::triangle_of(part, t);
      for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) {
        const int steps = 1 + static_cast<int>(length(to - from) / 0.05);
        for (int k = 0; k < steps; ++k) {
          points.push_back(from + static_cast<double>(k) / steps * (to - from));
        }
      }
    }
  }
  return points;
}

/// Proportion of the shoots that start neither near the wood nor at a shoot that does, and so on.
double detached_share(const Mesh& mesh) {
  const auto foliage = std::find_if(mesh.parts.begin(), mesh.parts.end(), [](const MeshPart& part) {
    return part.kind == PartKind::kFoliage;
  });
  if (foliage == mesh.parts.end()) return 0.0;
  const std::vector<Drawn> shoots = drawn_shoots(*foliage);
  std::vector<Point> wood = points_of_wood(mesh);
  std::ranges::sort(wood, {}, &Point::z);
  constexpr double kNear = 0.5;  // of a shoot's length
  std::vector<std::size_t> reached;
  std::vector<bool> is_reached(shoots.size(), false);
  const auto reach = [&](std::size_t i) {
    is_reached[i] = true;
    reached.push_back(i);
  };
  for (std::size_t i = 0; i < shoots.size(); ++i) {
    const Drawn& shoot = shoots[i];
    const double near = kNear * shoot.size_m;
    const auto [low, high] = std::minmax({shoot.base.z, shoot.tip.z});
    const auto begin = std::ranges::lower_bound(wood, low - near, {}, &Point::z);
    const auto end = std::ranges::upper_bound(wood, high + near, {}, &Point::z);
    if (std::any_of(begin, end, [&](Point p) { return distance_to_line(p, shoot) < near; })) {
      reach(i);
    }
  }
  for (std::size_t k = 0; k < reached.size(); ++k) {
    const Drawn from = shoots[reached[k]];
    for (std::size_t i = 0; i < shoots.size(); ++i) {
      if (!is_reached[i] && distance_to_line(shoots[i].base, from) < kNear * from.size_m) reach(i);
    }
  }
  return 1.0 - static_cast<double>(reached.size()) / static_cast<double>(shoots.size());
}

}  // namespace

// In nature leaves hide the wood that carries them; it is seen inside the crown and below.
TEST_CASE("leaves cover the wood near the surface of broadleaf crowns") {
  for (const char* name : {"quercus-robur",
                           "fagus",
                           "betula",
                           "populus",
                           "acer",
                           "fraxinus",
                           "machilus-pauhoi",
                           "schima-superba",
                           "generic-broadleaf"}) {
    const Builder& builder = all_builders().named(BuilderKind::kSegment, name);
    std::size_t covered = 0;
    std::size_t all = 0;
    for (int i = 0; i < 4; ++i) {
      Morphology tree = tall_tree(8.0);
      tree.tree = std::to_string(i);
      const SceneTree grown = grow_tree(tree, builder, {.mesh = {.textured = true}});
      const Crown crown(builder.shape_of(tree), builder.preset().crown_index);
      const MeshPart& foliage = grown.mesh.parts.back();
      for (const Point wood : points_of_wood(grown.mesh)) {
        // The outer fifth of the crown.
        const Point out{
            1.25 * wood.x, 1.25 * wood.y, crown.hc_m() + 1.25 * (wood.z - crown.hc_m())};
        if (wood.z < crown.hcb_m() || crown.contains(out)) continue;
        ++all;
        for (std::size_t t = 0; t < foliage.triangle_count(); ++t) {
          if (test::distance_to_triangle(wood, test::triangle_of(foliage, t)) > 0.2) continue;
          ++covered;
          break;
        }
      }
    }
    INFO(name << ": " << covered << " of " << all << " points");
    CHECK(static_cast<double>(covered) >= 0.9 * static_cast<double>(all));
  }
}

TEST_CASE("shoots are attached to the wood or to one another") {
  for (const BuilderKind kind : {BuilderKind::kSegment, BuilderKind::kLsystem, BuilderKind::kIfs}) {
    for (const Builder* builder : all_builders().of(kind)) {
      if (builder->name() == "fern") continue;  // its fronds are single cards
      for (const double cw_m : {4.0, 8.0, 12.0}) {
        const SceneTree grown = grow_tree(tall_tree(cw_m), *builder, {.mesh = {.textured = true}});
        const double share = detached_share(grown.mesh);
        INFO(builder->name() << ' ' << cw_m << ": " << share);
        // At the crown's surface shoots become so small that one may not reach the next.
        CHECK(share < 0.05);
      }
    }
  }
}
