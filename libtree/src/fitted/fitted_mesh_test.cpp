// SPDX-License-Identifier: MIT
// The properties of fitted skeletons, measured on their meshes.
#include "iterated_functions/ifs.hpp"
#include "silvafit/tree/smooth_mesh.hpp"
#include "test_support/fitted_test_support.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

void check_mesh(const Mesh& mesh, const TreeShape& shape, const Crown& crown) {
  test::check_mesh_measurements(shape, measure(mesh));
  double farthest = 0.0;
  for (const MeshPart& part : mesh.parts) {
    if (part.kind == PartKind::kStem) continue;
    for (std::size_t v = 0; v < part.vertex_count(); ++v) {
      farthest = std::max(farthest, crown.excess_m(test::vertex_of(part, v)));
    }
  }
  CHECK(farthest < 0.001);
}

}  // namespace

TEST_CASE("meshes of fitted skeletons have their measurements") {
  Random random(71);
  const SmoothStyle style{.leaves = {{}}};
  for (const Skeleton& grown : test::all_kinds()) {
    for (int i = 0; i < 30; ++i) {
      const test::Fitted tree = test::fitted(grown, test::random_morphology(random, i));
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        Random own(1);
        const Mesh mesh =
            build_smooth_mesh(tree.skeleton, tree.crown, style, own, level_of_detail(level));
        check_mesh(mesh, tree.shape, tree.crown);
      }
    }
  }
}

TEST_CASE("meshes of iterated function systems have their measurements") {
  for (const Builder* builder : test::shipped_builders().of(BuilderKind::kIfs)) {
    Random random(72);  // the same trees for each
    for (int i = 0; i < 25; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      const TreeShape shape = builder->shape_of(tree);
      const Crown crown(shape, builder->preset().crown_index);
      Random own = random_of_tree(1, tree.plot, tree.tree);
      const Skeleton skeleton = builder->grow_skeleton(shape, crown, own);
      INFO(builder->name());
      const Mesh mesh =
          builder->build_mesh(skeleton, crown, own, level_of_detail(i % kLevelsOfDetail));
      check_mesh(mesh, shape, crown);
    }
  }
}

TEST_CASE("a skeleton for a mesh with pictures of shoots is the same without leaves") {
  for (const BuilderKind kind : {BuilderKind::kLsystem, BuilderKind::kIfs}) {
    for (const Builder* builder : test::shipped_builders().of(kind)) {
      INFO(builder->name());
      const TreeShape shape = builder->shape_of(test::paper_tree_1());
      const Crown crown(shape, builder->preset().crown_index);
      Random for_all(3);
      Random for_mesh(3);
      Random for_plain(3);
      const Skeleton all = builder->grow_skeleton(shape, crown, for_all);
      const Skeleton bare = builder->grow_skeleton(shape, crown, for_mesh, {.textured = true});
      const Skeleton plain = builder->grow_skeleton(shape, crown, for_plain);
      CHECK(bare.leaves.empty());
      CHECK(plain.leaves.size() == all.leaves.size());
      REQUIRE(bare.axes.size() == all.axes.size());
      REQUIRE(bare.points.size() == all.points.size());
      for (std::size_t i = 0; i < all.points.size(); ++i) {
        REQUIRE(length(bare.points[i].at - all.points[i].at) == 0.0);
        REQUIRE(bare.points[i].radius_m == all.points[i].radius_m);
      }
    }
  }
}
