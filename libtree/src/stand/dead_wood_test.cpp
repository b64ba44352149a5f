// SPDX-License-Identifier: MIT
// Snags, stumps and logs have the measured sizes.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/tree/scene.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

Morphology dead_tree(Remains remains, std::optional<double> decay_class = {}) {
  return {.plot = "1",
          .tree = "7",
          .dbh_cm = 31.0,
          .h_m = 17.3,
          .hcb_m = 6.0,
          .cw_m = 5.0,
          .remains = remains,
          .decay_class = decay_class};
}

template <typename Check>
void with_every_builder(Check check) {
  for (const BuilderKind kind : silvafit::all_values<BuilderKind>()) {
    for (const Builder* const builder : test::shipped_builders().of(kind)) {
      INFO(silvafit::word_of(kind) << " " << builder->name());
      check(*builder);
    }
  }
}

std::size_t triangles_of(const Mesh& mesh, PartKind kind) {
  std::size_t count = 0;
  for (const MeshPart& part : mesh.parts) count += part.kind == kind ? part.triangle_count() : 0;
  return count;
}

}  // namespace

TEST_CASE("a snag has the measured height and DBH in every decay class, and no foliage") {
  with_every_builder([](const Builder& builder) {
    for (const double decay_class : {1.0, 2.0, 3.0, 4.0, 5.0}) {
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        for (const bool textured : {false, true}) {
          INFO("class " << decay_class << " level " << level << " textured " << textured);
          const Morphology tree = dead_tree(Remains::kSnag, decay_class);
          const SceneTree snag =
              grow_tree(tree, builder, {.mesh = level_of_detail(level, {.textured = textured})});
          // A float of 17.3 m has steps of 1e-6 m; a stem's section is exact but for those of its
          // corners.
          CHECK(snag.measured.h_m == Approx(tree.h_m).margin(2e-6));
          CHECK(snag.measured.dbh_cm == Approx(tree.dbh_cm).epsilon(1e-5));
          CHECK(triangles_of(snag.mesh, PartKind::kFoliage) == 0);
          if (decay_class > 3.0) CHECK(triangles_of(snag.mesh, PartKind::kBranches) == 0);
        }
      }
    }
  });
}

TEST_CASE("broken snags of any size have the measured height and DBH") {
  Random random(61);
  for (int i = 0; i < 200; ++i) {
    Morphology tree = test::random_morphology(random, i);
    tree.remains = Remains::kSnag;
    tree.decay_class = 1 + i % 5;
    // The last of them break just above the section of the DBH.
    if (i > 190) tree.h_m = std::max(1.31, tree.hcb_m + 0.01);
    INFO("tree " << i << " h " << tree.h_m << " dbh " << tree.dbh_cm);
    tree.hc_m.reset();
    const SceneTree snag =
        grow_tree(tree, test::shipped_builders().fallback(BuilderKind::kSegment));
    // Tubes of branches stay inside the crown to a millimeter (mesh_test.cpp); broken tops are
    // those of the stem, in floats.
    const double margin = *tree.decay_class == 1.0 ? 0.001 : 2e-6;
    CHECK(snag.measured.h_m == Approx(tree.h_m).epsilon(1e-7).margin(margin));
    CHECK(snag.measured.dbh_cm == Approx(tree.dbh_cm).epsilon(2e-5));
  }
}

TEST_CASE("older snags have fewer and shorter branches and thicker tops") {
  const Builder& builder = test::shipped_builders().fallback(BuilderKind::kSegment);
  std::size_t branches = 1000000;
  double top_cm = 0.0;
  for (const double decay_class : {1.0, 2.0, 3.0, 4.0}) {
    const SceneTree snag = grow_tree(dead_tree(Remains::kSnag, decay_class), builder);
    const std::size_t now = triangles_of(snag.mesh, PartKind::kBranches);
    CHECK(now < branches);
    branches = now;
    const double above = stem_diameters_cm(snag.mesh, std::array{16.5}).front();
    CHECK(above > top_cm);
    top_cm = above;
  }
}

TEST_CASE("a stump is what is left of the stem below the cut") {
  with_every_builder([](const Builder& builder) {
    const SceneTree living = grow_tree(dead_tree(Remains::kAll), builder);
    const SceneTree stump = grow_tree(dead_tree(Remains::kStump), builder);
    // FIA's stump: one foot.
    CHECK(stump.measured.h_m == Approx(0.3).margin(1e-6));
    const auto diameter = [](const SceneTree& tree) {
      return stem_diameters_cm(tree.mesh, std::array{0.15}).front();
    };
    // Sections that change the radius by less than 0.5 mm are omitted from the whole stem.
    CHECK(diameter(stump) == Approx(diameter(living)).margin(0.1));
  });
}

TEST_CASE("a log lies on the ground and is as long as the tree was high") {
  with_every_builder([](const Builder& builder) {
    const Morphology tree = dead_tree(Remains::kLog);
    const SceneTree log = grow_tree(tree, builder);
    CHECK(log.measured.h_m == Approx(tree.h_m).margin(2e-6));
    CHECK(log.measured.dbh_cm == Approx(tree.dbh_cm).epsilon(1e-5));
    double farthest = 0.0;
    double lowest = 1e9;
    double highest = 0.0;
    for (const MeshPart& part : log.mesh.parts) {
      CHECK(test::turned_triangles(part) == 0);
      for (std::size_t i = 0; i < part.vertex_count(); ++i) {
        const float* at = part.positions.data() + 3 * i;
        farthest = std::max(farthest, std::hypot<double>(at[0], at[2]));
        lowest = std::min<double>(lowest, at[1]);
        highest = std::max<double>(highest, at[1]);
      }
    }
    CHECK(farthest == Approx(tree.h_m).margin(1e-3));
    CHECK(lowest == Approx(0.0).margin(1e-6));
    CHECK(highest < 3.0);
  });
}
