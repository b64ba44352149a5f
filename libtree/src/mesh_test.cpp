// SPDX-License-Identifier: MIT
#include "silvafit/tree/mesh.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// A vertex in the tree's frame, z up.
Point vertex_of(const MeshPart& part, std::size_t i) {
  const float* at = part.positions.data() + 3 * i;
  return {at[0], -at[2], at[1]};
}

/// Directed edges between places, not between vertices: seams count as joined.
std::map<std::array<float, 6>, int> edges_of(const MeshPart& part) {
  std::map<std::array<float, 6>, int> edges;
  const auto& p = part.positions;
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = 3 * part.indices[i + j];
      const std::size_t b = 3 * part.indices[i + (j + 1) % 3];
      ++edges[{p[a], p[a + 1], p[a + 2], p[b], p[b + 1], p[b + 2]}];
    }
  }
  return edges;
}

double volume_m3(const MeshPart& part) {
  double volume = 0.0;
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    volume +=
        dot(vertex_of(part, part.indices[i]),
            cross(vertex_of(part, part.indices[i + 1]), vertex_of(part, part.indices[i + 2]))) /
        6.0;
  }
  return volume;
}

CrownRadii radii_of(const Morphology& tree) {
  if (tree.radii) return *tree.radii;
  const double radius = 0.5 * *tree.cw_m;
  return {radius, radius, radius, radius};
}

void check_promise(const Morphology& tree, const SceneTree& grown) {
  const Measurements& measured = grown.measured;
  const CrownRadii radii = radii_of(tree);
  INFO(grown.preset << " h " << tree.h_m << " hcb " << tree.hcb_m << " hc "
                    << tree.hc_m.value_or(-1) << " dbh " << tree.dbh_cm << " radii " << radii.east_m
                    << ' ' << radii.west_m << ' ' << radii.south_m << ' ' << radii.north_m);
  REQUIRE(measured.h_m == Approx(tree.h_m).margin(0.01));
  REQUIRE(measured.hcb_m == Approx(tree.hcb_m).margin(0.01));
  REQUIRE(measured.dbh_cm == Approx(tree.dbh_cm).margin(0.1));
  REQUIRE(measured.radii.east_m == Approx(radii.east_m).margin(0.01));
  REQUIRE(measured.radii.west_m == Approx(radii.west_m).margin(0.01));
  REQUIRE(measured.radii.south_m == Approx(radii.south_m).margin(0.01));
  REQUIRE(measured.radii.north_m == Approx(radii.north_m).margin(0.01));
  REQUIRE(measured.radii.width_m() == Approx(radii.width_m()).margin(0.01));
}

void check_buffers(const MeshPart& part) {
  REQUIRE(part.positions.size() == part.normals.size());
  REQUIRE((part.colors.empty() || part.colors.size() == 4 * part.vertex_count()));
  REQUIRE(part.indices.size() % 3 == 0);
  for (const std::uint32_t index : part.indices) REQUIRE(index < part.vertex_count());
  for (std::size_t i = 0; i < part.normals.size(); i += 3) {
    const float* n = part.normals.data() + i;
    const double size = std::sqrt(double{n[0]} * n[0] + double{n[1]} * n[1] + double{n[2]} * n[2]);
    REQUIRE(size == Approx(1.0).margin(1e-6));
  }
}

}  // namespace

TEST_CASE("any legal tree of any preset has its measurements on the mesh") {
  constexpr int kTrees = 60;
  Random random(20);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < kTrees; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      check_promise(tree, grow_tree(tree, preset));
    }
  }
}

TEST_CASE("extreme but legal trees keep the promise") {
  const auto tree = [](double dbh, double h, double hcb, double cw) {
    return Morphology{.plot = "x", .tree = "1", .dbh_cm = dbh, .h_m = h, .hcb_m = hcb, .cw_m = cw};
  };
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (const Morphology& extreme : {tree(0.1, 1.3 + 1e-9, 0, 0.1),
                                      tree(50, 1.31, 1.305, 3),
                                      tree(1, 1.5, 1.499, 12),
                                      tree(1900, 140, 0, 100),
                                      tree(80, 10, 9.99, 0.02),
                                      tree(10, 4, 0, 20)}) {
      check_promise(extreme, grow_tree(extreme, preset));
    }
  }
}

TEST_CASE("no vertex of branches or foliage leaves the crown by a millimeter") {
  Random random(21);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 10; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      const Crown crown(complete(tree, preset.relative_hc, ""), preset.crown_index);
      const SceneTree grown = grow_tree(tree, preset);
      for (const MeshPart& part : grown.mesh.parts) {
        check_buffers(part);
        if (part.kind == PartKind::kStem) continue;
        for (std::size_t v = 0; v < part.vertex_count(); ++v) {
          REQUIRE(crown.excess_m(vertex_of(part, v)) < 0.001);
        }
      }
    }
  }
}

TEST_CASE("the stem is closed, faces outwards and has the taper's volume") {
  const Morphology tree = test::paper_tree_1();
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const SceneTree grown = grow_tree(tree, preset);
  const MeshPart& stem = grown.mesh.parts.front();
  REQUIRE(stem.kind == PartKind::kStem);
  const auto edges = edges_of(stem);
  for (const auto& [edge, count] : edges) {
    REQUIRE(count == 1);
    REQUIRE(edges.count({edge[3], edge[4], edge[5], edge[0], edge[1], edge[2]}) == 1);
  }
  // Integral of the section's area over fine steps; the mesh is straight between its sections.
  double volume = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double d = preset.taper.diameter_cm(tree.h_m * (i + 0.5) / kSteps, tree.h_m, 20.0) / 100;
    volume += std::numbers::pi / 4.0 * d * d * tree.h_m / kSteps;
  }
  CHECK(volume_m3(stem) == Approx(volume).epsilon(0.01));
}

TEST_CASE("the number of sides and sections changes neither DBH nor height") {
  const Preset& preset = test::shipped_presets().named("generic-broadleaf");
  for (const int sides : {3, 7, 40}) {
    for (const double tolerance : {0.0, 0.0005, 1.0}) {
      const GrowOptions options{.mesh = {.stem_sides = sides, .stem_tolerance_m = tolerance}};
      check_promise(test::paper_tree_1(), grow_tree(test::paper_tree_1(), preset, options));
    }
  }
  const GrowOptions flat{.mesh = {.stem_sides = 2}};
  CHECK_THROWS_AS(grow_tree(test::paper_tree_1(), preset, flat), UsageError);
}

TEST_CASE("trees have a few thousand triangles") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    const SceneTree grown = grow_tree(test::paper_tree_1(), preset);
    CHECK(grown.measured.triangles >= 3000);
    CHECK(grown.measured.triangles <= 8000);
  }
}

TEST_CASE("order and threads do not change a tree, the seed does") {
  const Preset& preset = test::shipped_presets().named("generic-conifer");
  Random random(22);
  std::vector<Morphology> trees;
  for (int i = 0; i < 12; ++i) trees.push_back(test::random_morphology(random, i));
  std::vector<SceneTree> parallel(trees.size());
  parallel_for(trees.size(), 4, [&](std::size_t i) { parallel[i] = grow_tree(trees[i], preset); });
  for (std::size_t i = trees.size(); i-- > 0;) {
    const SceneTree alone = grow_tree(trees[i], preset);
    for (std::size_t p = 0; p < alone.mesh.parts.size(); ++p) {
      CHECK(alone.mesh.parts[p].positions == parallel[i].mesh.parts[p].positions);
      CHECK(alone.mesh.parts[p].normals == parallel[i].mesh.parts[p].normals);
      CHECK(alone.mesh.parts[p].colors == parallel[i].mesh.parts[p].colors);
      CHECK(alone.mesh.parts[p].indices == parallel[i].mesh.parts[p].indices);
    }
  }
  const SceneTree other = grow_tree(trees[0], preset, {.seed = 2});
  CHECK(other.mesh.parts[1].positions != parallel[0].mesh.parts[1].positions);
}

TEST_CASE("the measuring tape works on a mesh that is no tree of ours") {
  // A square prism from the ground to 2 m with a section of 0.04 m2, and one crown triangle.
  MeshPart prism{.kind = PartKind::kStem};
  prism.positions = {-0.1F, 0, 0.1F, 0.1F, 0, 0.1F, 0.1F, 0, -0.1F, -0.1F, 0, -0.1F,
                     -0.1F, 2, 0.1F, 0.1F, 2, 0.1F, 0.1F, 2, -0.1F, -0.1F, 2, -0.1F};
  prism.indices = {0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
  MeshPart crown{.kind = PartKind::kFoliage};
  crown.positions = {1.5F, 1.75F, 0, -0.5F, 3, 0, 0, 2, -2};
  crown.indices = {0, 1, 2};
  const Measurements measured = measure({.parts = {prism, crown}});
  CHECK(measured.dbh_cm == Approx(100 * std::sqrt(0.04 * 4 / std::numbers::pi)).epsilon(1e-6));
  CHECK(measured.h_m == 3.0);
  CHECK(measured.hcb_m == 1.75);
  CHECK(measured.radii.east_m == 1.5);
  CHECK(measured.radii.west_m == 0.5);
  CHECK(measured.radii.north_m == 2.0);
  CHECK(measured.radii.south_m == 0.0);
  CHECK_THROWS_AS(measure({.parts = {prism}}), GeometryError);
  CHECK_THROWS_AS(measure({.parts = {crown}}), GeometryError);
}
