// SPDX-License-Identifier: MIT
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "fitted/standing_skeleton.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/lsystem_builder.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

Skeleton drawn(BuilderKind kind, const std::string& name, double h_m) {
  Random random(1);
  const Builder& builder = test::shipped_builders().named(kind, name);
  return scaled_to_height(builder.grow_freely(h_m, random), h_m);
}

Morphology only_height(double h_m) { return {.plot = "1", .tree = "1", .h_m = h_m}; }

SceneTree unfitted(BuilderKind kind, const std::string& name, double h_m, bool textured) {
  return grow_tree(only_height(h_m),
                   test::shipped_builders().named(kind, name),
                   {.mesh = {.textured = textured}, .is_unfitted = true});
}

/// Angle between the first segment of an axis and the segment of its parent that ends at its base.
double branching_angle_deg(const Skeleton& tree, const Axis& axis) {
  const auto line = tree.points_of(axis);
  const Point own = direction(line[1].at - line[0].at);
  const auto parent = tree.points_of(tree.axes[axis.parent]);
  std::size_t end = 1;
  for (std::size_t i = 1; i < parent.size(); ++i) {
    if (length(parent[i].at - line[0].at) < length(parent[end].at - line[0].at)) end = i;
  }
  const Point along = direction(parent[end].at - parent[end - 1].at);
  return std::acos(std::clamp(dot(own, along), -1.0, 1.0)) / kRadian;
}

}  // namespace

TEST_CASE("an unfitted tree of figure 7 has the angles and ratios of the paper's table") {
  // Shi, Cheng and Zhang, table 1: r1, r2, a0, a2.
  const std::map<std::string, std::array<double, 4>> table{{"honda-7a", {0.80, 0.67, 45, 54}},
                                                           {"honda-7b", {0.45, 0.38, 90, 45}},
                                                           {"honda-7c", {0.90, 0.40, 57, 50}},
                                                           {"honda-7d", {0.55, 0.60, 80, 65}}};
  for (const auto& [name, row] : table) {
    INFO(name);
    const Skeleton tree = drawn(BuilderKind::kLsystem, name, 12.0);
    const auto stem = tree.points_of(tree.axes.front());
    CHECK(stem.back().at.z == Approx(12.0).epsilon(1e-12));
    // Axes are seen in a picture of the whole tree: 0.2 % of its height thick, above breast height.
    CHECK(std::all_of(tree.points.begin(), tree.points.end(), [](const SkeletonPoint& point) {
      return point.radius_m == 0.0 || point.at.z <= kBreastHeight || point.radius_m >= 0.012;
    }));
    const double first_m = stem[1].at.z - stem[0].at.z;
    for (std::size_t i = 1; i < tree.axes.size(); ++i) {
      const Axis& axis = tree.axes[i];
      CHECK(branching_angle_deg(tree, axis) ==
            Approx(axis.order == 1 ? row[2] : row[3]).epsilon(1e-9));
      if (axis.order > 1) continue;
      const auto line = tree.points_of(axis);
      // The k-th branch of the stem: r2 times its bearer, r1^(k - 1) times the first segment.
      const auto base = std::find_if(stem.begin(), stem.end(), [&](const SkeletonPoint& point) {
        return length(point.at - line[0].at) < 1e-9;
      });
      REQUIRE(base != stem.end());
      CHECK(length(line[1].at - line[0].at) / first_m ==
            Approx(row[1] * std::pow(row[0], static_cast<double>(base - stem.begin() - 1)))
                .epsilon(1e-9));
    }
  }
}

TEST_CASE("a fitted tree nearly keeps its branching angles") {
  // 7a to 7d of the paper: the angle between stem and branch.
  const std::map<std::string, double> angles{
      {"honda-7a", 45}, {"honda-7b", 90}, {"honda-7c", 57}, {"honda-7d", 80}};
  const Morphology tree{.plot = "1", .tree = "1", .dbh_cm = 24, .h_m = 12, .hcb_m = 3.6, .cw_m = 6};
  for (const auto& [name, angle_deg] : angles) {
    INFO(name);
    const Builder& builder = test::shipped_builders().named(BuilderKind::kLsystem, name);
    const TreeShape shape = builder.shape_of(tree);
    const Crown crown(shape, builder.preset().crown_index);
    Random random(1);
    const Skeleton fitted = builder.grow_skeleton(shape, crown, random);
    int turned = 0;
    for (const Axis& axis : fitted.axes) {
      if (axis.order != 1) continue;
      const auto line = fitted.points_of(axis);
      const Point along = direction(line.back().at - line.front().at);
      // By at most 15 degrees, unless the crown leaves no room; a branch of these trees is
      // straight.
      constexpr double kMost = 15.0 + 0.1;
      if (std::abs(std::acos(along.z) / kRadian - angle_deg) > kMost) ++turned;
    }
    // The branch at the crown base has no room below it.
    CHECK(turned <= 1);
  }
}

TEST_CASE("an unfitted tree needs its height only") {
  for (const BuilderKind kind : {BuilderKind::kLsystem, BuilderKind::kIfs}) {
    for (const Builder* builder : test::shipped_builders().of(kind)) {
      for (const bool textured : {false, true}) {
        INFO(builder->name() << (textured ? " textured" : " plain"));
        const SceneTree tree = unfitted(kind, builder->name(), 15.0, textured);
        const Skeleton skeleton = drawn(kind, builder->name(), 15.0);
        // Leaves may stand above the highest axis by their length, and shoots by at most 1.2 m
        // (80 cm, enlarged by up to half).
        double longest_m = 1.2;
        for (const LeafSite& leaf : skeleton.leaves) longest_m = std::max(longest_m, leaf.length_m);
        CHECK(tree.measured.h_m >= 15.0 - 0.01);
        // A smooth curve may rise above the points of its axis by some centimeters.
        CHECK(tree.measured.h_m < 15.0 + longest_m + 0.05);
        CHECK(tree.measured.dbh_cm > 0.0);
        for (const MeshPart& part : tree.mesh.parts) CHECK_FALSE(part.indices.empty());
      }
    }
  }
}

TEST_CASE("the mesh of an unfitted bare tree has the extent of its axes") {
  for (const char* const name : {"honda-7a", "honda-7b", "honda-7c", "honda-7d"}) {
    INFO(name);
    const SceneTree tree = unfitted(BuilderKind::kLsystem, name, 10.0, true);
    const TreeShape shape = shape_of(drawn(BuilderKind::kLsystem, name, 10.0));
    double east = 0.0;
    double north = 0.0;
    for (const MeshPart& part : tree.mesh.parts) {
      if (part.kind != PartKind::kBranches) continue;
      for (std::size_t i = 0; i < part.positions.size(); i += 3) {
        east = std::max(east, static_cast<double>(part.positions[i]));
        north = std::max(north, -static_cast<double>(part.positions[i + 2]));
      }
    }
    CHECK(tree.measured.h_m == Approx(10.0).margin(0.001));
    // A smooth curve through the points of an axis bends out by little.
    CHECK(east == Approx(shape.radii.east_m).margin(0.15));
    CHECK(north == Approx(shape.radii.north_m).margin(0.15));
  }
}

TEST_CASE("the leaves of a flat drawing have a tenth of its width as depth") {
  // Two limbs, 4 m to the east and 3 m to the west.
  const Skeleton flat{.points = {{{0, 0, 0}, 0.1},
                                 {{0, 0, 10}, 0.0},
                                 {{0, 0, 5}, 0.05},
                                 {{4, 0, 7}, 0.0},
                                 {{0, 0, 5}, 0.05},
                                 {{-3, 0, 7}, 0.0}},
                      .axes = {{.count = 2},
                               {.order = 1, .first = 2, .count = 2},
                               {.order = 1, .first = 4, .count = 2}}};
  const TreeShape shape = shape_of(flat);
  CHECK(shape.radii.east_m == 4.0);
  CHECK(shape.radii.west_m == 3.0);
  CHECK(shape.radii.north_m == Approx(0.4).epsilon(1e-12));
  CHECK(shape.radii.south_m == Approx(0.4).epsilon(1e-12));
}

TEST_CASE("trees whose branches follow the measurements cannot be unfitted") {
  CHECK_THROWS_AS(unfitted(BuilderKind::kSegment, "generic-conifer", 15.0, true), UsageError);
  CHECK_THROWS_AS(unfitted(BuilderKind::kBamboo, "moso", 15.0, true), UsageError);
  CHECK_THROWS_AS(unfitted(BuilderKind::kIfs, "fern", 1.2, true), DomainError);
}

TEST_CASE("a drawing that does not rise is no tree") {
  Skeleton flat{.points = {{{0, 0, 0}, 0.1}, {{1, 0, 0}, 0.0}, {{1, 0, 0}, 0.05}, {{1, 1, 0}, 0.0}},
                .axes = {{.count = 2}, {.order = 1, .first = 2, .count = 2}}};
  CHECK_THROWS_AS(scaled_to_height(flat, 10.0), GeometryError);
  flat.points.back().at.z = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(scaled_to_height(flat, 10.0), GeometryError);
}
