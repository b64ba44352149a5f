// SPDX-License-Identifier: MIT
#include "mesh/shoot_cards.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

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

}  // namespace

TEST_CASE("the shoots of a tree have its leaf area") {
  for (const char* name : {"generic-broadleaf", "schima-superba", "cunninghamia-lanceolata"}) {
    const Preset& preset = test::shipped_presets().named(name);
    for (const double cw_m : {4.0, 6.0}) {
      const SceneTree grown = grow_tree(tall_tree(cw_m), preset, {.mesh = {.textured = true}});
      const MeshPart& foliage = grown.mesh.parts.back();
      REQUIRE(foliage.kind == PartKind::kFoliage);
      const double covered = shoot_atlas(preset.leafy_shoots.picture).covered;
      const double leaf_area_index =
          covered * area_m2(foliage) / (0.25 * std::numbers::pi * cw_m * cw_m);
      INFO(name << ' ' << cw_m << ": " << foliage.triangle_count() / 4 << " shoots");
      // More in crowns wider than 5 m. Shoots at the crown's surface are smaller, so that they stay
      // inside.
      const double wanted = std::max(1.0, cw_m / 5.0) * preset.leafy_shoots.leaf_area_index;
      CHECK(leaf_area_index <= 1.1 * wanted);
      CHECK(leaf_area_index >= 0.45 * wanted);
    }
  }
}

TEST_CASE("leaves have the length in their picture, unless the crown is very large or small") {
  const Preset& preset = test::shipped_presets().named("schima-superba");
  const auto number = [&](double cw_m) {
    const Crown crown(complete(tall_tree(cw_m), preset.relative_hc, ""), preset.crown_index);
    return number_of_shoots(preset.leafy_shoots, crown, 1e6);
  };
  CHECK(number(5.0).scale == 1.0);
  CHECK(number(8.0).scale == 1.0);
  // In a crown of 1 m shoots have 0.2 m; a crown of 30 m would need too many short ones.
  CHECK(number(1.0).scale == Approx(0.2 / preset.leafy_shoots.length_m).epsilon(1e-9));
  CHECK(number(30.0).scale > 1.0);
  CHECK(number(30.0).shoots <= 1700);
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
  const LeafyShoots fronds{
      .picture = ShootKind::kFrond, .lift = 0.0, .cross_deg = 20.0, .is_whole_twig = true};
  MeshPart foliage{.kind = PartKind::kFoliage};
  PartBuilder build(foliage);
  Random random(1);
  add_shoots(tree.take(), crown, fronds, 0.1, random, {.textured = true}, {}, build);
  build.finish();
  // Two cards for each twig, and for the top of the stem.
  REQUIRE(foliage.triangle_count() == 12);
  for (std::size_t card = 0; card < 4; ++card) {
    // The first two corners are those at the base.
    const Point base =
        0.5 * (test::vertex_of(foliage, 4 * card) + test::vertex_of(foliage, 4 * card + 1));
    const Point end =
        0.5 * (test::vertex_of(foliage, 4 * card + 2) + test::vertex_of(foliage, 4 * card + 3));
    const bool is_first = card < 2;
    CHECK(length(base - Point{is_first ? 1.0 : 2.0, 0.0, 9.0}) < 1e-5);
    CHECK(length(end - base) == Approx(is_first ? 0.8 : 0.5).epsilon(1e-5));
  }
}

TEST_CASE("trees of every preset with pictures have at most some ten thousand triangles") {
  for (const BuilderKind kind : kBuilders) {
    for (const Builder* builder : all_builders().of(kind)) {
      for (const double cw_m : {3.0, 7.0, 14.0}) {
        const SceneTree grown = grow_tree(tall_tree(cw_m), *builder, {.mesh = {.textured = true}});
        INFO(builder->name() << ' ' << cw_m << ": " << grown.mesh.triangle_count());
        // A banyan has some thousand triangles of aerial roots.
        CHECK(grown.mesh.triangle_count() <= 16000);
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
  const SceneTree grown =
      grow_tree(tall_tree(7.0), test::shipped_presets().fallback(), {.mesh = {.textured = true}});
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
