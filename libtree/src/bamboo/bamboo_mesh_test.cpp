// SPDX-License-Identifier: MIT
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "bamboo/bamboo.hpp"
#include "test_support/bamboo_test_support.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

TEST_CASE("the mesh has a section at breast height") {
  // If a piece of the curve ends at 1.3 m except for rounding, the section belongs to that end.
  const Morphology tree{
      .plot = "b", .tree = "1069", .dbh_cm = 23.8, .h_m = 2.3, .hcb_m = 0.8, .cw_m = 0.7};
  for (int level = 0; level < kLevelsOfDetail; ++level) {
    const SceneTree grown = grow_tree(tree, test::moso(), {.mesh = level_of_detail(level)});
    CHECK(grown.measured.dbh_cm == Approx(23.8).epsilon(1e-5));
  }
}

TEST_CASE("the mesh of any valid bamboo has its measurements, closed and inside the crown") {
  Random random(41);
  for (int i = 0; i < 120; ++i) {
    const Morphology tree = test::random_morphology(random, i);
    INFO("tree " << i << " dbh " << tree.dbh_cm << " h " << tree.h_m << " hcb " << tree.hcb_m
                 << " cw " << tree.cw_m.value_or(-1.0) << " hc " << tree.hc_m.value_or(-1.0));
    const Crown crown(test::moso().shape_of(tree), test::moso().preset().crown_index);
    const MeshOptions base{.closed_branches = true, .textured = i % 2 == 0};
    const MeshOptions options = level_of_detail(i % kLevelsOfDetail, base);
    const SceneTree bamboo = grow_tree(tree, test::moso(), {.mesh = options});
    test::check_mesh_measurements(tree, bamboo);
    for (const MeshPart& part : bamboo.mesh.parts) {
      INFO(part_name(part.kind));
      if (part.kind != PartKind::kFoliage) CHECK(test::open_edges(part) == 0);
      if (part.kind == PartKind::kStem) {
        CHECK(test::volume_m3(part) > 0.0);
        continue;
      }
      double outside = 0.0;
      for (std::size_t v = 0; v < part.vertex_count(); ++v) {
        outside = std::max(outside, crown.excess_m(test::vertex_of(part, v)));
      }
      CHECK(outside < 0.001);
    }
  }
}

TEST_CASE("the culm's mesh has ridges, and the measured diameter at breast height") {
  const SceneTree bamboo =
      grow_tree(test::usual_culm(), test::moso(), {.mesh = level_of_detail(0)});
  CHECK(bamboo.measured.dbh_cm == Approx(10.0).epsilon(1e-5));
  const MeshPart& stem = bamboo.mesh.parts.front();
  // Highest vertices of the tube by height, in the straight part below the crown.
  std::map<float, double> radius_at;
  for (std::size_t v = 0; v < stem.vertex_count(); ++v) {
    const Point at = test::vertex_of(stem, v);
    if (at.z > 0.5 && at.z < 7.5) {
      double& radius = radius_at[static_cast<float>(at.z)];
      radius = std::max(radius, std::hypot(at.x, at.y));
    }
  }
  std::size_t ridges = 0;
  double before = 1e9;
  bool rising = false;
  for (const auto& [z, radius] : radius_at) {
    if (radius > 1.03 * before) rising = true;
    if (rising && radius < 0.98 * before) {
      ++ridges;
      rising = false;
    }
    before = radius;
  }
  // 14 m in 54 internodes or so, the longest below the middle: 7 m of it have 20 to 30 nodes.
  CHECK(ridges >= 18);
  CHECK(ridges <= 32);
}

TEST_CASE("cards have the pictures of their grades") {
  const SceneTree bamboo =
      grow_tree(test::usual_culm(), test::moso(), {.mesh = {.textured = true}});
  const MeshPart& foliage = bamboo.mesh.parts.back();
  REQUIRE(foliage.kind == PartKind::kFoliage);
  REQUIRE(foliage.texture);
  const auto grades = test::moso().preset().leaves.pictures.size();
  CHECK(foliage.texture->width == grades * foliage.texture->height);
  CHECK(foliage.double_sided);
  // Two cards of two triangles a site.
  const test::Bamboo skeleton = test::grown(test::usual_culm());
  CHECK(foliage.triangle_count() <= 4 * skeleton.skeleton.leaves.size());
  CHECK(foliage.triangle_count() > 3 * skeleton.skeleton.leaves.size());
  // Each card has one picture.
  bool in_one = true;
  for (std::size_t i = 0; i < foliage.triangle_count(); ++i) {
    double least = 1.0;
    double most = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double u = foliage.uvs[std::size_t{2} * foliage.indices[3 * i + k]];
      least = std::min(least, u);
      most = std::max(most, u);
    }
    const double share = 1.0 / static_cast<double>(grades);
    in_one = in_one && std::abs(most - least - share) < 1e-6;
  }
  CHECK(in_one);
}
