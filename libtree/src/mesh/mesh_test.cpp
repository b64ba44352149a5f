// SPDX-License-Identifier: MIT
#include "silvafit/tree/mesh.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

void check_buffers(const MeshPart& part) {
  REQUIRE(part.positions.size() == part.normals.size());
  REQUIRE((part.colors.empty() || part.colors.size() == 4 * part.vertex_count()));
  REQUIRE((part.uvs.empty() || part.uvs.size() == 2 * part.vertex_count()));
  REQUIRE((part.tangents.empty() || part.tangents.size() == 4 * part.vertex_count()));
  REQUIRE(part.indices.size() % 3 == 0);
  for (const std::uint32_t index : part.indices) REQUIRE(index < part.vertex_count());
  for (std::size_t i = 0; i < part.vertex_count(); ++i) {
    REQUIRE(length(test::normal_of(part, i)) == Approx(1.0).margin(1e-6));
  }
  // A branch's closed base shares its corners, and so their normals, with its sides.
  INFO(part_name(part.kind) << " triangles " << part.triangle_count());
  REQUIRE(test::least_doubled_area(part) > 0.0);
  if (part.kind != PartKind::kBranches) REQUIRE(test::turned_triangles(part) == 0);
}

/// The properties of a mesh with any options.
void check_mesh(const Morphology& tree, const Preset& preset, const MeshOptions& options) {
  INFO(preset.name << " dbh " << tree.dbh_cm << " h " << tree.h_m << " hcb " << tree.hcb_m);
  const SceneTree grown = grow_tree(tree, preset, {.mesh = options});
  test::check_mesh_measurements(tree, grown);
  REQUIRE(grown.measured.radii.width_m() == Approx(test::radii_of(tree).width_m()).margin(0.01));
  for (const MeshPart& part : grown.mesh.parts) check_buffers(part);
}

}  // namespace

TEST_CASE("the mesh of any valid tree of any preset has its measurements") {
  constexpr int kTrees = 60;
  Random random(20);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < kTrees; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        INFO("level " << level);
        check_mesh(tree, preset, level_of_detail(level));
      }
    }
  }
}

TEST_CASE("pictures, colors and closed branches change no measurement") {
  Random random(23);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 12; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      check_mesh(tree, preset, {.closed_branches = true, .textured = true});
      check_mesh(tree, preset, level_of_detail(i % kLevelsOfDetail, {.textured = true}));
    }
  }
}

TEST_CASE("meshes of extreme but valid trees have their measurements") {
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
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        check_mesh(extreme, preset, level_of_detail(level, {.closed_branches = true}));
      }
    }
  }
}

TEST_CASE("all vertices of branches and foliage are inside the crown, to a millimeter") {
  Random random(21);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 10; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      const Crown crown(complete(tree, preset.relative_hc, ""), preset.crown_index);
      const SceneTree grown = grow_tree(
          tree, preset, {.mesh = level_of_detail(i % kLevelsOfDetail, {.textured = i % 2 == 0})});
      for (const MeshPart& part : grown.mesh.parts) {
        if (part.kind == PartKind::kStem) continue;
        for (std::size_t v = 0; v < part.vertex_count(); ++v) {
          REQUIRE(crown.excess_m(test::vertex_of(part, v)) < 0.001);
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
  REQUIRE(test::open_edges(stem) == 0);
  // Integral of the section's area over fine steps; the mesh is straight between its sections.
  double volume = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double d =
        preset.taper
            .diameters_cm(
                std::array<double, 1>{tree.h_m * (i + 0.5) / kSteps}, tree.h_m, tree.dbh_cm)
            .front() /
        100;
    volume += std::numbers::pi / 4.0 * d * d * tree.h_m / kSteps;
  }
  CHECK(test::volume_m3(stem) == Approx(volume).epsilon(0.01));
}

TEST_CASE("stem and branches are closed on request") {
  Random random(24);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 20; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      for (const bool textured : {false, true}) {
        const MeshOptions options =
            level_of_detail(i % kLevelsOfDetail, {.closed_branches = true, .textured = textured});
        const SceneTree grown = grow_tree(tree, preset, {.mesh = options});
        for (const MeshPart& part : grown.mesh.parts) {
          if (part.kind == PartKind::kFoliage) continue;
          INFO(preset.name << ' ' << part_name(part.kind) << ' ' << i);
          CHECK(test::open_edges(part) == 0);
          if (part.kind == PartKind::kBranches && !textured) {
            CHECK(test::open_or_split_edges(part) == 0);
          }
          CHECK(test::volume_m3(part) > 0.0);
        }
      }
    }
  }
  const SceneTree open =
      grow_tree(test::paper_tree_1(), test::shipped_presets().named("generic-broadleaf"));
  CHECK(test::open_edges(open.mesh.parts[1]) > 0);
}

TEST_CASE("bark and leaves have correct texture coordinates") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    const SceneTree grown = grow_tree(test::paper_tree_1(), preset, {.mesh = {.textured = true}});
    for (const MeshPart& part : grown.mesh.parts) {
      for (std::size_t i = 0; i < part.triangle_count(); ++i) {
        const auto corners = test::triangle_of(part, i);
        const std::uint32_t* index = part.indices.data() + 3 * i;
        const auto u = [&](int k) { return double{part.uvs[std::size_t{2} * index[k]]}; };
        const auto v = [&](int k) { return double{part.uvs[std::size_t{2} * index[k] + 1]}; };
        const Point face = cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double area = (u(1) - u(0)) * (v(2) - v(0)) - (u(2) - u(0)) * (v(1) - v(0));
        // The tip of a tube is one vertex with one u; triangles there have a slanting picture.
        if (std::abs(area) < 1e-6) continue;
        // Lengyel's tangent: the direction in which u increases and v is constant.
        const Point tangent = (1.0 / area) * ((v(2) - v(0)) * (corners[1] - corners[0]) -
                                              (v(1) - v(0)) * (corners[2] - corners[0]));
        const float* given = part.tangents.data() + std::size_t{4} * index[0];
        const Point of_vertex{given[0], -given[2], given[1]};
        REQUIRE(length(of_vertex) == Approx(1.0).margin(1e-6));
        REQUIRE(std::abs(given[3]) == 1.0F);
        const bool is_foot = part.kind == PartKind::kStem && face.z < -0.9 * length(face);
        // Where the stem widens into its roots, the picture is stretched.
        const bool is_above_roots = std::min({corners[0].z, corners[1].z, corners[2].z}) > 1.15;
        if (part.kind == PartKind::kStem && !is_foot && is_above_roots && corners[2].z < 20.0) {
          // Stems of twelve sides: a face is 15 degrees away from its corners' directions.
          CHECK(dot(direction(tangent), of_vertex) > std::cos(20.0 * std::numbers::pi / 180.0));
        }
        for (int k = 0; k < 3; ++k) {
          if (part.kind != PartKind::kFoliage) continue;
          REQUIRE((u(k) >= 0.0 && u(k) <= 1.0 && v(k) >= 0.0 && v(k) <= 1.0));
        }
      }
    }
  }
}

TEST_CASE("each level of detail is coarser and within its stated surface error") {
  Random random(25);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 3; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      const SceneTree finest = grow_tree(tree, preset);
      CHECK(finest.mesh.surface_error_m == 0.0);
      std::size_t triangles = finest.measured.triangles;
      double error = 0.0;
      for (int level = 1; level < kLevelsOfDetail; ++level) {
        const SceneTree coarse = grow_tree(tree, preset, {.mesh = level_of_detail(level)});
        const double stated = coarse.mesh.surface_error_m;
        const double measured = std::max(test::farthest_wood_m(finest.mesh, coarse.mesh),
                                         test::farthest_wood_m(coarse.mesh, finest.mesh));
        INFO(preset.name << " level " << level << " stated " << stated << " measured " << measured);
        // Floats resolve these coordinates to a few micrometers; the rings that the crown curve
        // makes smaller may move by half a millimeter.
        CHECK(measured <= stated + 0.0005);
        // Twigs that are not drawn count by their distance from their own branch; in the flat
        // sprays of beech, other branches are up to four times nearer.
        if (i == 0) CHECK(measured >= 0.25 * stated);
        CHECK(stated >= error);
        CHECK(coarse.measured.triangles < triangles);
        triangles = coarse.measured.triangles;
        error = stated;
      }
    }
  }
}

TEST_CASE("a level of detail that does not exist is refused") {
  CHECK_THROWS_AS(level_of_detail(kLevelsOfDetail), UsageError);
  CHECK_THROWS_AS(level_of_detail(-1), UsageError);
}

TEST_CASE("a coarser crown covers as much of its outline as the finest one") {
  // Thinning keeps the sum of the leaves' areas, except for overlaps and for what the crown curve
  // cuts off.
  const auto area = [](const Mesh& mesh) {
    double sum = 0.0;
    for (const MeshPart& part : mesh.parts) {
      if (part.kind != PartKind::kFoliage) continue;
      for (std::size_t i = 0; i < part.triangle_count(); ++i) {
        const auto [a, b, c] = test::triangle_of(part, i);
        sum += 0.5 * length(cross(b - a, c - a));
      }
    }
    return sum;
  };
  for (const char* name : {"machilus-pauhoi", "schima-superba", "generic-broadleaf"}) {
    const Preset& preset = test::shipped_presets().named(name);
    const double finest = area(grow_tree(test::paper_tree_1(), preset).mesh);
    for (int level = 1; level < kLevelsOfDetail; ++level) {
      INFO(name << ' ' << level);
      const Mesh mesh =
          grow_tree(test::paper_tree_1(), preset, {.mesh = level_of_detail(level)}).mesh;
      CHECK(area(mesh) > 0.6 * finest);
      CHECK(area(mesh) < 1.4 * finest);
    }
  }
}

TEST_CASE("a triangle needs 22 bytes of vertices and indices") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    const SceneTree grown = grow_tree(test::paper_tree_1(), preset);
    INFO(preset.name);
    CHECK(static_cast<double>(glb_mesh_bytes(grown.mesh)) <=
          22.0 * static_cast<double>(grown.measured.triangles));
  }
}

TEST_CASE("the number of sides and sections changes neither DBH nor height") {
  const Preset& preset = test::shipped_presets().named("generic-broadleaf");
  for (const int sides : {3, 7, 40}) {
    for (const double tolerance : {0.0, 0.0005, 1.0}) {
      const GrowOptions options{.mesh = {.stem_sides = sides, .stem_tolerance_m = tolerance}};
      test::check_mesh_measurements(test::paper_tree_1(),
                                    grow_tree(test::paper_tree_1(), preset, options));
    }
  }
  const GrowOptions flat{.mesh = {.stem_sides = 2}};
  CHECK_THROWS_AS(grow_tree(test::paper_tree_1(), preset, flat), UsageError);
}

TEST_CASE("trees have a few thousand triangles") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    const SceneTree grown = grow_tree(test::paper_tree_1(), preset);
    INFO(preset.name);
    CHECK(grown.measured.triangles >= 3000);
    CHECK(grown.measured.triangles <= 8500);
  }
}

TEST_CASE("a tree depends on the seed, not on order and threads") {
  const Preset& preset = test::shipped_presets().named("generic-conifer");
  Random random(22);
  std::vector<Morphology> trees;
  trees.reserve(12);
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

TEST_CASE("measure() works on any mesh") {
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
