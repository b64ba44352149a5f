// SPDX-License-Identifier: MIT
#include "silvafit/tree/skeleton.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

double angle_from_vertical_deg(const Skeleton& skeleton, const Axis& axis) {
  const auto points = skeleton.points_of(axis);
  const Point chord = points.back().at - points.front().at;
  return std::atan2(std::hypot(chord.x, chord.y), chord.z) * 180.0 / std::numbers::pi;
}

}  // namespace

TEST_CASE("first-order branches end on the crown curve, within a millimeter") {
  Random random(11);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 40; ++i) {
      const auto [shape, crown, skeleton] =
          test::stages_of(test::random_morphology(random, i), preset);
      for (const Axis& axis : skeleton.axes) {
        if (axis.order != 1) continue;
        const Point tip = skeleton.points_of(axis).back().at;
        REQUIRE(crown.excess_m(tip) < 0.001);
        const double distance = std::hypot(tip.x, tip.y);
        const double radius = crown.radius_m(tip.x, tip.y);
        const double gap = std::min(std::abs(tip.z - crown.up_m(distance, radius)),
                                    std::abs(tip.z - crown.down_m(distance, radius)));
        REQUIRE(gap < 0.001);
      }
    }
  }
}

TEST_CASE("all axes of the crown are inside it, to a millimeter") {
  Random random(12);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 40; ++i) {
      const auto [shape, crown, skeleton] =
          test::stages_of(test::random_morphology(random, i), preset);
      for (const Axis& axis : skeleton.axes) {
        if (axis.order == 0) continue;
        for (const SkeletonPoint& point : skeleton.points_of(axis)) {
          REQUIRE(crown.excess_m(point.at) < 0.001);
          REQUIRE(point.radius_m >= 0.0);
        }
      }
    }
  }
}

TEST_CASE("branch angles of Chinese fir are in the published interval of their layer") {
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const auto [shape, crown, skeleton] = test::stages_of(test::paper_tree_1(), preset);
  std::vector<Axis> branches;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order == 1) branches.push_back(axis);
  }
  REQUIRE(branches.size() > 80);
  branches.resize(branches.size() - 4);  // the last four are bound to the measured radii
  for (const Axis& axis : branches) {
    const double base = skeleton.points_of(axis).front().at.z;
    const double share = (base - shape.hcb_m) / (shape.h_m - shape.hcb_m);
    const double low = share < 0.333333 ? 70 : share < 0.666667 ? 50 : 30;
    const double angle = angle_from_vertical_deg(skeleton, axis);
    CHECK(angle >= low - 1e-6);
    CHECK(angle <= low + 20 + 1e-6);
  }
}

TEST_CASE("second-order branches of Chinese fir make flat sprays within the published angles") {
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const auto [shape, crown, skeleton] = test::stages_of(test::paper_tree_1(), preset);
  int twigs = 0;
  int to_the_left = 0;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order != 2) continue;
    const auto branch = skeleton.points_of(skeleton.axes[axis.parent]);
    const auto twig = skeleton.points_of(axis);
    const Point along = direction(branch.back().at - branch.front().at);
    const Point side = direction(cross({0.0, 0.0, 1.0}, along));
    const Point over = cross(along, side);
    const Point chord = direction(twig.back().at - twig.front().at);
    const double angle = std::acos(dot(chord, along)) * 180.0 / std::numbers::pi;
    CHECK(angle >= 50.0 - 1e-6);
    CHECK(angle <= 100.0 + 1e-6);
    // 135-225 and 315-45 degrees: at most 45 degrees out of the spray's plane on either side.
    CHECK(std::abs(dot(chord, over)) <= std::abs(dot(chord, side)) + 1e-9);
    ++twigs;
    to_the_left += dot(chord, side) > 0.0 ? 1 : 0;
  }
  CHECK(twigs > 300);
  // Pairs, except for those that the crown's surface cuts off.
  CHECK(to_the_left == Approx(0.5 * twigs).epsilon(0.05));
}

TEST_CASE("whorls of Chinese fir point in four directions") {
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const auto [shape, crown, skeleton] = test::stages_of(test::paper_tree_1(), preset);
  std::map<double, std::vector<double>> azimuths;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order != 1) continue;
    const auto points = skeleton.points_of(axis);
    const Point chord = points.back().at - points.front().at;
    azimuths[points.front().at.z].push_back(std::atan2(chord.x, chord.y));
  }
  int whorls = 0;
  for (auto& [base, whorl] : azimuths) {
    if (whorl.size() != 4) continue;  // the branches at the measured radii are single
    ++whorls;
    std::sort(whorl.begin(), whorl.end());
    for (std::size_t i = 0; i < 4; ++i) {
      const double next = i < 3 ? whorl[i + 1] : whorl[0] + 2.0 * std::numbers::pi;
      // A right angle within the difference of two azimuths with standard deviation 10 degrees.
      CHECK(next - whorl[i] ==
            Approx(0.5 * std::numbers::pi).margin(60.0 * std::numbers::pi / 180));
    }
  }
  CHECK(whorls >= 15);
}

TEST_CASE("a broadleaf's stem divides into limbs that bear two more orders") {
  for (const char* name : {"generic-broadleaf", "machilus-pauhoi", "schima-superba"}) {
    const Preset& preset = test::shipped_presets().named(name);
    const auto [shape, crown, skeleton] = test::stages_of(test::paper_tree_1(), preset);
    const auto stem = skeleton.points_of(skeleton.axes.front());
    int limbs = 0;
    std::map<std::uint32_t, int> of_order;
    for (const Axis& axis : skeleton.axes) {
      ++of_order[axis.order];
      if (axis.order != 1) continue;
      const SkeletonPoint& base = skeleton.points_of(axis).front();
      const auto above = std::find_if(stem.begin(), stem.end(), [&](const SkeletonPoint& point) {
        return point.at.z >= base.at.z;
      });
      if (base.radius_m > 0.95 * preset.branching.fork.thickness * above->radius_m) {
        const double share = (base.at.z - shape.hcb_m) / (shape.h_m - shape.hcb_m);
        const bool in_zone =
            share > preset.branching.fork.from - 0.01 && share < preset.branching.fork.to + 0.01;
        limbs += in_zone ? 1 : 0;
      }
    }
    INFO(name);
    CHECK(limbs >= preset.branching.fork.limbs);
    CHECK(of_order[2] > of_order[1]);
    CHECK(of_order[3] > of_order[2]);
  }
}

TEST_CASE("four branches reach the measured radii, and one starts at the crown base") {
  const Morphology tree = test::paper_tree_1();
  for (const Preset& preset : test::shipped_presets().presets()) {
    const test::Stages stages = test::stages_of(tree, preset);
    const Skeleton& skeleton = stages.skeleton;
    double lowest = 100.0;
    bool east = false;
    bool west = false;
    bool south = false;
    bool north = false;
    for (const Axis& axis : skeleton.axes) {
      if (axis.order != 1) continue;
      lowest = std::min(lowest, skeleton.points_of(axis).front().at.z);
      const Point tip = skeleton.points_of(axis).back().at;
      const auto at = [&](double x, double y) { return length(tip - Point{x, y, 8.8}) < 1e-9; };
      east = east || at(2.1, 0);
      west = west || at(-2.5, 0);
      south = south || at(0, -1.5);
      north = north || at(0, 2.4);
    }
    CHECK(lowest == 5.8);
    CHECK((east && west && south && north));
  }
}

TEST_CASE("the branches of a whorl start at different heights if the preset spreads them") {
  Preset preset = test::shipped_presets().named("generic-conifer");
  const auto bases_m = [&](double spread) {
    preset.branching.whorl_spread = spread;
    const test::Stages stages = test::stages_of(test::paper_tree_1(), preset);
    std::set<double> heights;
    std::size_t branches = 0;
    for (const Axis& axis : stages.skeleton.axes) {
      if (axis.order != 1) continue;
      heights.insert(stages.skeleton.points_of(axis).front().at.z);
      ++branches;
    }
    CHECK(*heights.begin() == 5.8);
    return std::pair(heights.size(), branches);
  };
  const auto [whorls, branches] = bases_m(0.0);
  // Four branches to the measured radii start at heights of their own.
  CHECK(whorls <= (branches - 4) / 4 + 4);
  const auto [spread_heights, spread_branches] = bases_m(0.8);
  CHECK(spread_branches == branches);
  CHECK(spread_heights >= branches - 4);
}

TEST_CASE("axes have correct parents and orders") {
  const test::Stages stages =
      test::stages_of(test::paper_tree_1(), test::shipped_presets().named("schima-superba"));
  const Skeleton& skeleton = stages.skeleton;
  REQUIRE(skeleton.axes.front().order == 0);
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    REQUIRE(axis.parent < i);
    REQUIRE(axis.order == skeleton.axes[axis.parent].order + 1);
    REQUIRE(axis.count >= 2);
    REQUIRE(axis.first + axis.count <= skeleton.points.size());
  }
}

TEST_CASE("a tree depends only on the seed, its plot and its name") {
  CHECK(random_of_tree(1, "1", "12").bits() == random_of_tree(1, "1", "12").bits());
  CHECK(random_of_tree(1, "1", "12").bits() != random_of_tree(1, "11", "2").bits());
  CHECK(random_of_tree(1, "1", "12").bits() != random_of_tree(2, "1", "12").bits());
  CHECK(random_of_tree(1, "", "12").bits() != random_of_tree(1, "12", "").bits());
}
