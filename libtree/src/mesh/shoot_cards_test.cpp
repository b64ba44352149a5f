// SPDX-License-Identifier: MIT
#include "mesh/shoot_cards.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/tree/builder.hpp"
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

TEST_CASE("trees of every preset with pictures have at most some ten thousand triangles") {
  for (const BuilderKind kind : kBuilders) {
    for (const Builder* builder : all_builders().of(kind)) {
      for (const double cw_m : {3.0, 7.0, 14.0}) {
        const SceneTree grown = grow_tree(tall_tree(cw_m), *builder, {.mesh = {.textured = true}});
        INFO(builder->name() << ' ' << cw_m << ": " << grown.mesh.triangle_count());
        CHECK(grown.mesh.triangle_count() <= 15000);
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
