// SPDX-License-Identifier: MIT
// Freely grown skeletons, and checks of skeletons fitted to measurements.
#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "silvafit/tree/fitted_skeleton.hpp"
#include "test_support/tree_test_support.hpp"

namespace silvafit::test {

using tree::Axis;
using tree::Crown;
using tree::CrownIndex;
using tree::CrownRadii;
using tree::LeafSite;
using tree::Morphology;
using tree::Point;
using tree::Skeleton;
using tree::SkeletonPoint;
using tree::Taper;
using tree::TreeShape;

/// Builds skeletons by hand, axis by axis.
class HandMade {
 public:
  /// \return index of the new axis
  std::uint32_t axis(std::uint32_t parent, const std::vector<SkeletonPoint>& points) {
    const bool is_stem = skeleton_.axes.empty();
    skeleton_.axes.push_back({.order = is_stem ? 0 : skeleton_.axes[parent].order + 1,
                              .parent = parent,
                              .first = static_cast<std::uint32_t>(skeleton_.points.size()),
                              .count = static_cast<std::uint32_t>(points.size())});
    skeleton_.points.insert(skeleton_.points.end(), points.begin(), points.end());
    return static_cast<std::uint32_t>(skeleton_.axes.size() - 1);
  }
  void leaf(std::uint32_t axis, Point at, Point along, double length) {
    const Point facing = direction(cross(along, {0.3, 0.2, 1.0}));
    skeleton_.leaves.push_back({at, direction(along), facing, length, axis, 0});
  }
  Skeleton take() { return std::move(skeleton_); }

 private:
  Skeleton skeleton_{};
};

/// Four level branches at one height.
inline Skeleton cross_tree() {
  HandMade tree;
  tree.axis(0, {{{0, 0, 0}, 1}, {{0, 0, 10}, 0.1}});
  for (const Point out : {Point{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}) {
    const Point tip = Point{0, 0, 6} + 5.0 * out;
    const auto axis =
        tree.axis(0, {{{0, 0, 6}, 0.3}, {Point{0, 0, 6} + 2.5 * out, 0.2}, {tip, 0.05}});
    tree.leaf(axis, tip, out, 0.4);
  }
  return tree.take();
}

/// Branches in a spiral round a stem that leans, from the ground up.
inline Skeleton leaning_spiral(double lean) {
  HandMade tree;
  const auto stem_at = [lean](double z) { return Point{lean * z, 0.1 * std::sin(z), z}; };
  std::vector<SkeletonPoint> stem;
  for (int i = 0; i <= 20; ++i) stem.push_back({stem_at(0.4 * i), 0.3 - 0.0145 * i});
  tree.axis(0, stem);
  for (int i = 0; i < 30; ++i) {
    const double z = 0.4 + 0.25 * i;
    const double azimuth = 2.399963 * i;
    const Point out{std::cos(azimuth), std::sin(azimuth), 0.5};
    const Point base = stem_at(z);
    const double reach = 3.0 - 0.08 * i;
    const auto axis = tree.axis(0,
                                {{base, 0.05},
                                 {base + 0.5 * reach * out, 0.03},
                                 {base + reach * out + Point{0, 0, -0.3}, 0.01}});
    tree.leaf(axis, base + 0.6 * reach * out, {0, 0, 1}, 0.2);
    tree.leaf(axis, base + reach * out, out, 0.2);
  }
  return tree.take();
}

/// One branch only, on one side.
inline Skeleton flag_tree() {
  HandMade tree;
  tree.axis(0, {{{3, 4, 1}, 0.2}, {{3, 4, 5}, 0.1}});
  tree.axis(0, {{{3, 4, 3}, 0.1}, {{4, 4, 4}, 0.02}});
  return tree.take();
}

/// A stem that forks repeatedly at its tip, as in sympodial trees.
class Forking {
 public:
  explicit Forking(int depth, std::uint64_t seed) : depth_(depth), random_(seed) {}
  Skeleton grow() {
    const auto stem = tree_.axis(0, {{{0, 0, 0}, 0.1}, {{0.02, 0.01, 1}, 0.09}});
    fork(stem, {0.02, 0.01, 1}, {0, 0, 1}, 0.8, 1);
    return tree_.take();
  }

 private:
  void fork(std::uint32_t bearer, Point at, Point along, double size, int level) {
    if (level > depth_) return;
    const double turn = random_.uniform(0.0, 6.3);
    for (int i = 0; i < 3; ++i) {
      const double azimuth = turn + 2.1 * i;
      const Point out = direction(
          along + random_.uniform(0.3, 0.9) *
                      Point{std::cos(azimuth), std::sin(azimuth), random_.uniform(-0.3, 0.3)});
      const Point tip = at + size * out;
      const double radius = 0.09 * std::pow(0.7, level);
      const auto axis = tree_.axis(
          bearer, {{at, radius}, {at + 0.5 * size * out, 0.9 * radius}, {tip, 0.8 * radius}});
      tree_.leaf(axis, tip, out, 0.1);
      fork(axis, tip, out, 0.75 * size, level + 1);
    }
  }
  int depth_;
  Random random_;
  HandMade tree_{};
};

inline std::vector<Skeleton> all_kinds() {
  return {cross_tree(),
          leaning_spiral(0.0),
          leaning_spiral(0.6),
          flag_tree(),
          Forking(4, 1).grow(),
          Forking(2, 2).grow()};
}

struct Fitted {
  const Taper* taper = nullptr;
  TreeShape shape;
  Crown crown;
  Skeleton skeleton;
};

inline Fitted fitted(const Skeleton& grown, const Morphology& tree, CrownIndex index = {}) {
  const Taper& taper = shipped_presets().named("generic-broadleaf").taper;
  TreeShape shape = complete(tree, 0.35, "test");
  Crown crown(shape, index);
  Skeleton skeleton = fit_to_measurements(grown, shape, crown, taper);
  return {&taper, std::move(shape), std::move(crown), std::move(skeleton)};
}

inline std::string text_of(const TreeShape& shape) {
  return "dbh " + std::to_string(shape.dbh_cm) + " h " + std::to_string(shape.h_m) + " hcb " +
         std::to_string(shape.hcb_m) + " hc " + std::to_string(shape.hc_m) + " radii " +
         std::to_string(shape.radii.east_m) + ' ' + std::to_string(shape.radii.west_m) + ' ' +
         std::to_string(shape.radii.south_m) + ' ' + std::to_string(shape.radii.north_m);
}

/// Checks of the stem.
inline void check_stem(const Fitted& tree) {
  const auto stem = tree.skeleton.points_of(tree.skeleton.axes.front());
  REQUIRE(tree.skeleton.axes.front().order == 0);
  REQUIRE(stem.front().at.z == 0.0);
  REQUIRE(length(stem.back().at - Point{0, 0, tree.shape.h_m}) == 0.0);
  REQUIRE(stem.back().radius_m == 0.0);
  bool at_breast_height = false;
  for (std::size_t i = 0; i < stem.size(); ++i) {
    if (i > 0) REQUIRE(stem[i].at.z > stem[i - 1].at.z);
    if (stem[i].at.z <= 1.3) REQUIRE((stem[i].at.x == 0.0 && stem[i].at.y == 0.0));
    const double diameter_cm =
        tree.taper
            ->diameters_cm(std::array<double, 1>{stem[i].at.z}, tree.shape.h_m, tree.shape.dbh_cm)
            .front();
    REQUIRE(200.0 * stem[i].radius_m == Approx(diameter_cm).margin(1e-9));
    if (stem[i].at.z != 1.3) continue;
    at_breast_height = true;
    REQUIRE(200.0 * stem[i].radius_m == Approx(tree.shape.dbh_cm).epsilon(1e-12));
  }
  REQUIRE(at_breast_height);
}

inline void check_axes(const Fitted& tree) {
  const Skeleton& skeleton = tree.skeleton;
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    REQUIRE(axis.parent < i);
    REQUIRE(axis.order == skeleton.axes[axis.parent].order + 1);
    REQUIRE(axis.count >= 2);
    REQUIRE(axis.first + axis.count <= skeleton.points.size());
    for (const SkeletonPoint& point : skeleton.points_of(axis)) {
      // Inside except for rounding.
      REQUIRE(tree.crown.excess_m(point.at) < 1e-9 * tree.shape.h_m + 1e-12);
      REQUIRE(point.radius_m >= 0.0);
    }
  }
}

inline void check_leaves(const Fitted& tree) {
  for (const LeafSite& leaf : tree.skeleton.leaves) {
    REQUIRE(leaf.axis < tree.skeleton.axes.size());
    REQUIRE(length(leaf.along) == Approx(1.0).epsilon(1e-9));
    REQUIRE(length(leaf.facing) == Approx(1.0).epsilon(1e-9));
    REQUIRE(std::abs(dot(leaf.along, leaf.facing)) < 1e-9);
    REQUIRE(leaf.length_m > 0.0);
    REQUIRE(leaf.length_m <= 0.8);
    REQUIRE(tree.crown.excess_m(leaf.at) < 1e-9 * tree.shape.h_m);
    REQUIRE(tree.crown.excess_m(leaf.at + leaf.length_m * leaf.along) < 1e-9 * tree.shape.h_m);
  }
}

/// The measurements of branches and leaves, from their lines instead of a mesh.
inline void check_measurements(const Fitted& tree) {
  const Skeleton& skeleton = tree.skeleton;
  double lowest = std::numeric_limits<double>::infinity();
  double highest = 0.0;
  CrownRadii radii{};
  const auto see = [&](Point p) {
    lowest = std::min(lowest, p.z);
    highest = std::max(highest, p.z);
    const double sector = std::tan(0.5 * std::numbers::pi / 180.0);
    const double out = std::hypot(p.x, p.y);
    if (std::abs(p.y) <= sector * std::abs(p.x)) {
      double& radius = p.x > 0 ? radii.east_m : radii.west_m;
      radius = std::max(radius, out);
    } else if (std::abs(p.x) <= sector * std::abs(p.y)) {
      double& radius = p.y > 0 ? radii.north_m : radii.south_m;
      radius = std::max(radius, out);
    }
  };
  std::array<bool, 4> ends{};
  for (std::size_t i = 1; i < skeleton.axes.size(); ++i) {
    const auto line = skeleton.points_of(skeleton.axes[i]);
    for (const SkeletonPoint& point : line) see(point.at);
    const CrownRadii& r = tree.shape.radii;
    const double hc = tree.shape.hc_m;
    const std::array<Point, 4> wanted{
        {{r.east_m, 0, hc}, {-r.west_m, 0, hc}, {0, -r.south_m, hc}, {0, r.north_m, hc}}};
    for (std::size_t d = 0; d < 4; ++d) {
      const Point tip = line.back().at;
      ends[d] = ends[d] || (tip.x == wanted[d].x && tip.y == wanted[d].y && tip.z == wanted[d].z);
    }
  }
  for (const LeafSite& leaf : skeleton.leaves) {
    see(leaf.at);
    see(leaf.at + leaf.length_m * leaf.along);
  }
  CHECK((ends[0] && ends[1] && ends[2] && ends[3]));
  CHECK(highest <= tree.shape.h_m);
  CHECK(lowest == Approx(tree.shape.hcb_m).margin(1e-12));
  // Between two directions with very different radii the crown is wider half a degree away.
  CHECK(radii.east_m == Approx(tree.shape.radii.east_m).margin(0.001));
  CHECK(radii.west_m == Approx(tree.shape.radii.west_m).margin(0.001));
  CHECK(radii.south_m == Approx(tree.shape.radii.south_m).margin(0.001));
  CHECK(radii.north_m == Approx(tree.shape.radii.north_m).margin(0.001));
}

inline void check_fitted(const Fitted& tree) {
  INFO(text_of(tree.shape));
  check_stem(tree);
  check_axes(tree);
  check_leaves(tree);
  check_measurements(tree);
}

}  // namespace silvafit::test
