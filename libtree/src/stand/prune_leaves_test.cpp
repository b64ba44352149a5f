// SPDX-License-Identifier: MIT
// Leaves of trees whose crowns overlap.
#include <set>

#include "silvafit/tree/overlap.hpp"
#include "test_support/fitted_test_support.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

struct Grown {
  Morphology morphology;
  TreeShape shape;
  Crown crown;
  Skeleton skeleton;
};

Grown grown(const Builder& builder, Morphology tree) {
  const TreeShape shape = builder.shape_of(tree);
  const Crown crown(shape, builder.preset().crown_index);
  Random random = random_of_tree(1, tree.plot, tree.tree);
  Skeleton skeleton = builder.grow_skeleton(shape, crown, random);
  return {std::move(tree), shape, crown, std::move(skeleton)};
}

double distance_from_axis(const Skeleton& skeleton, const LeafSite& leaf) {
  double least = 1e9;
  const auto line = skeleton.points_of(skeleton.axes[leaf.axis]);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point along = line[i].at - line[i - 1].at;
    const Point away = leaf.at - line[i - 1].at;
    const double squared = dot(along, along);
    const double part = squared > 0 ? std::clamp(dot(away, along) / squared, 0.0, 1.0) : 0.0;
    least = std::min(least, length(away - part * along));
  }
  return least;
}

}  // namespace

TEST_CASE("leaves stay on their axes when crowns that overlap are pruned") {
  for (const Builder* builder : test::shipped_builders().of(BuilderKind::kIfs)) {
    INFO(builder->name());
    Morphology neighbor = test::paper_tree_10();
    neighbor.tree = "neighbor";
    neighbor.position.y_m -= 1.5;
    neighbor.h_m -= 1.0;
    std::vector<Grown> trees{grown(*builder, test::paper_tree_10()), grown(*builder, neighbor)};
    std::vector<StandTree> stand;
    stand.reserve(trees.size());
    for (const Grown& tree : trees) {
      stand.push_back(stand_tree(tree.morphology, tree.crown, tree.skeleton));
    }
    // The four measured radii are unchanged.
    for (const StandTree& tree : stand) CHECK(tree.radius_branches.size() >= 4);
    const StandOverlap overlap = resolve_overlaps(stand, 1);
    REQUIRE(overlap.pairs.size() == 1);
    for (std::size_t t = 0; t < trees.size(); ++t) {
      const Grown& tree = trees[t];
      const PrunedSkeleton pruned = prune(tree.skeleton, tree.crown, overlap.trees[t]);
      const Skeleton& now = pruned.skeleton;
      CHECK(pruned.removed_share() > 0.0);
      CHECK(pruned.removed_share() < 0.6);
      CHECK(now.axes.size() < tree.skeleton.axes.size());
      CHECK(now.leaves.size() < tree.skeleton.leaves.size());
      CHECK(now.leaves.size() > tree.skeleton.leaves.size() / 3);
      for (const LeafSite& leaf : now.leaves) {
        REQUIRE(leaf.axis < now.axes.size());
        REQUIRE(std::abs(dot(leaf.along, leaf.facing)) < 1e-9);
        REQUIRE(tree.crown.excess_m(leaf.at) < 1e-9);
        REQUIRE(tree.crown.excess_m(leaf.at + leaf.length_m * leaf.along) < 1e-9);
      }
      // Leaves that were on their axis still are; only leaves that would be outside the crown were
      // moved, before or now.
      const auto off_axis = [](const Skeleton& skeleton) {
        std::size_t off = 0;
        for (const LeafSite& leaf : skeleton.leaves) {
          if (distance_from_axis(skeleton, leaf) > 1e-6) ++off;
        }
        return off;
      };
      CHECK(off_axis(now) <= off_axis(tree.skeleton) + now.leaves.size() / 50);
      // The leaves of unchanged axes are unchanged.
      std::set<std::array<double, 3>> before;
      for (const LeafSite& leaf : tree.skeleton.leaves) {
        before.insert({leaf.at.x, leaf.at.y, leaf.at.z});
      }
      std::size_t same = 0;
      for (const LeafSite& leaf : now.leaves) {
        same += before.count({leaf.at.x, leaf.at.y, leaf.at.z});
      }
      CHECK(same > now.leaves.size() / 2);
    }
  }
}

TEST_CASE("the leaves of a removed limb are removed, and the others keep theirs") {
  const test::Fitted tree = test::fitted(test::leaning_spiral(0.0), test::paper_tree_10());
  const std::vector<std::uint32_t> removed{3, 7};
  const PrunedSkeleton pruned = prune(tree.skeleton, tree.crown, {.removed = removed});
  std::size_t expected = 0;
  for (const LeafSite& leaf : tree.skeleton.leaves) {
    expected += leaf.axis != 3 && leaf.axis != 7 ? 1 : 0;
  }
  REQUIRE(pruned.skeleton.leaves.size() == expected);
  std::size_t k = 0;
  for (const LeafSite& leaf : tree.skeleton.leaves) {
    if (leaf.axis == 3 || leaf.axis == 7) continue;
    const LeafSite& now = pruned.skeleton.leaves[k++];
    const std::uint32_t gone = leaf.axis > 7 ? 2 : leaf.axis > 3 ? 1 : 0;
    CHECK(now.axis == leaf.axis - gone);
    CHECK(length(now.at - leaf.at) == 0.0);
    CHECK(length(now.along - leaf.along) == 0.0);
  }
}

TEST_CASE("leaves and twigs of a branch with a new course move with it") {
  test::HandMade made;
  made.axis(0, {{{0, 0, 0}, 0.2}, {{0, 0, 10}, 0}});
  const auto branch = made.axis(0, {{{0, 0, 5}, 0.1}, {{2, 0, 5}, 0}});
  const auto twig = made.axis(branch, {{{1, 0, 5}, 0.02}, {{1, 0.5, 5}, 0}});
  const auto shoot = made.axis(twig, {{{1, 0.25, 5}, 0.01}, {{1.2, 0.25, 5}, 0}});
  made.leaf(branch, {1.5, 0, 5}, {1, 0, 0}, 0.1);
  made.leaf(shoot, {1.2, 0.25, 5}, {1, 0, 0}, 0.1);
  const Skeleton skeleton = made.take();
  const TreeShape shape{.dbh_cm = 20, .h_m = 10, .hcb_m = 2, .hc_m = 5, .radii = {4, 4, 4, 4}};
  const Crown crown(shape, {});
  // A quarter turn to the north.
  const BranchLine turned{.axis = branch, .points = {{{0, 0, 5}, 0.1}, {{0, 2, 5}, 0}}};
  const Skeleton now = prune(skeleton, crown, {.turned = {turned}}).skeleton;
  REQUIRE(now.axes.size() == 4);
  REQUIRE(now.leaves.size() == 2);
  CHECK(length(now.leaves[0].at - Point{0, 1.5, 5}) < 1e-12);
  CHECK(length(now.leaves[0].along - Point{0, 1, 0}) < 1e-12);
  // Twigs are moved, not turned: by (-1, 1, 0), from the middle to the new middle.
  CHECK(length(now.points_of(now.axes[2]).front().at - Point{0, 1, 5}) < 1e-12);
  CHECK(length(now.points_of(now.axes[3]).front().at - Point{0, 1.25, 5}) < 1e-12);
  CHECK(length(now.leaves[1].at - Point{0.2, 1.25, 5}) < 1e-12);
  CHECK(length(now.leaves[1].along - Point{1, 0, 0}) < 1e-12);
}
