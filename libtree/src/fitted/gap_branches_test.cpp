// SPDX-License-Identifier: MIT
#include "fitted/gap_branches.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "segments/skeleton_line.hpp"
#include "test_support/fitted_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

constexpr double kGap = 0.25;

/// Distance to the nearest branch in radii of the crown and halves of its length.
double gap_at(const Skeleton& skeleton, const Crown& crown, Point place) {
  const double along = 2.0 / (crown.h_m() - crown.hcb_m());
  const auto scaled = [&](Point at) {
    const double across = 1.0 / crown.radius_m(at.x, at.y);
    return Point{across * at.x, across * at.y, along * at.z};
  };
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    walk(skeleton.points_of(skeleton.axes[i]), [&](double /*share*/, const SkeletonPoint& point) {
      nearest = std::min(nearest, length(scaled(point.at) - scaled(place)));
      return true;
    });
  }
  return nearest;
}

/// Places all round at four fifths of the crown's width, without its pointed ends.
std::vector<double> gaps_near_surface(const Skeleton& skeleton, const Crown& crown) {
  std::vector<double> gaps;
  for (int layer = 3; layer < 18; ++layer) {
    const double z = crown.hcb_m() + layer / 20.0 * (crown.h_m() - crown.hcb_m());
    for (int i = 0; i < 16; ++i) {
      const double azimuth = 2.0 * std::numbers::pi * i / 16;
      const Point out{std::cos(azimuth), std::sin(azimuth), 0.0};
      Point place = 0.8 * crown.radius_m(out.x, out.y) * crown.relative_width(z) * out;
      place.z = z;
      gaps.push_back(gap_at(skeleton, crown, place));
    }
  }
  return gaps;
}

Morphology usual() {
  return {.plot = "1", .tree = "1", .dbh_cm = 24, .h_m = 16, .hcb_m = 4.5, .cw_m = 8};
}

}  // namespace

TEST_CASE("branches are added where a crown is empty") {
  for (const Skeleton& grown : test::all_kinds()) {
    test::Fitted tree = test::fitted(grown, usual());
    const Skeleton before = tree.skeleton;
    const std::vector<double> gaps = gaps_near_surface(before, tree.crown);
    const double widest = *std::max_element(gaps.begin(), gaps.end());
    fill_gaps(tree.skeleton, tree.crown, kGap);
    const Skeleton& after = tree.skeleton;
    // What was there stays.
    REQUIRE(after.axes.size() >= before.axes.size());
    for (std::size_t i = 0; i < before.points.size(); ++i) {
      REQUIRE(length(after.points[i].at - before.points[i].at) == 0.0);
      REQUIRE(after.points[i].radius_m == before.points[i].radius_m);
    }
    test::check_axes(tree);
    test::check_leaves(tree);
    // A place between those that are tried is at most half of their distance from one: 0.06 along
    // the crown's length, 0.11 around it, and 0.08 across, because they are farther out. Together
    // 0.15.
    const std::vector<double> filled = gaps_near_surface(after, tree.crown);
    INFO("widest gap " << widest << ", filled " << *std::max_element(filled.begin(), filled.end()));
    CHECK(std::all_of(filled.begin(), filled.end(), [](double gap) { return gap < kGap + 0.15; }));
    if (widest > kGap + 0.15) CHECK(after.axes.size() > before.axes.size());
  }
}

TEST_CASE("added branches are thinner than what they grow from, and bear leaves as others do") {
  test::Fitted tree = test::fitted(test::leaning_spiral(0.0), usual());
  const std::size_t grown = tree.skeleton.axes.size();
  double longest_m = 0.0;
  for (const LeafSite& leaf : tree.skeleton.leaves) longest_m = std::max(longest_m, leaf.length_m);
  fill_gaps(tree.skeleton, tree.crown, 0.15);
  const Skeleton& skeleton = tree.skeleton;
  REQUIRE(skeleton.axes.size() > grown);
  for (std::uint32_t i = static_cast<std::uint32_t>(grown); i < skeleton.axes.size(); ++i) {
    const auto line = skeleton.points_of(skeleton.axes[i]);
    const auto bearer = skeleton.points_of(skeleton.axes[skeleton.axes[i].parent]);
    const PlaceOnLine place = nearest_place(bearer, line.front().at);
    const SkeletonPoint& a = bearer[place.segment];
    const SkeletonPoint& b = bearer[place.segment + 1];
    // It starts on its bearer.
    CHECK(length(a.at + place.part * (b.at - a.at) - line.front().at) < 1e-9);
    CHECK(line.front().radius_m < a.radius_m + place.part * (b.radius_m - a.radius_m));
    const auto leaves =
        std::count_if(skeleton.leaves.begin(), skeleton.leaves.end(), [&](const LeafSite& leaf) {
          return leaf.axis == i && leaf.length_m <= longest_m;
        });
    CHECK(leaves > 0);
  }
}

TEST_CASE("a full crown gets no branches") {
  test::Fitted tree = test::fitted(test::leaning_spiral(0.0), usual());
  const std::size_t grown = tree.skeleton.axes.size();
  fill_gaps(tree.skeleton, tree.crown, 2.0);
  CHECK(tree.skeleton.axes.size() == grown);
}
