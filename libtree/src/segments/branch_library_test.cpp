// SPDX-License-Identifier: MIT
#include "silvafit/tree/branch_library.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// Distance of the vertex nearest to a point.
double nearest_vertex_m(const MeshPart& part, Point to) {
  double least = 1e9;
  for (std::size_t i = 0; i < part.vertex_count(); ++i) {
    least = std::min(least, length(test::vertex_of(part, i) - to));
  }
  return least;
}

}  // namespace

TEST_CASE("the library has the paper's 7 angles and 8 lengths, each branch with its tip") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    const BranchLibrary library = BranchLibrary::build(preset);
    REQUIRE(library.models().size() == 56);
    CHECK(library.models().front().angle_deg == 30.0);
    CHECK(library.models().front().length_m == Approx(0.4).epsilon(1e-12));
    CHECK(library.models().back().angle_deg == 90.0);
    CHECK(library.models().back().length_m == Approx(3.2).epsilon(1e-12));
    for (const BranchModel& model : library.models()) {
      REQUIRE(model.mesh.parts.size() == 2);
      const double angle = kRadian * model.angle_deg;
      const Point tip{model.length_m * std::sin(angle), 0.0, model.length_m * std::cos(angle)};
      INFO(preset.name << ' ' << model.angle_deg << ' ' << model.length_m);
      // Floats resolve coordinates near 10 m, where the branch grew, to a micrometer.
      CHECK(nearest_vertex_m(model.mesh.parts[0], tip) < 1e-5);
      for (const MeshPart& part : model.mesh.parts) {
        CHECK(part.kind != PartKind::kStem);
        CHECK(test::least_doubled_area(part) > 0.0);
        for (std::size_t i = 0; i < part.vertex_count(); ++i) {
          // Twigs of a branch are shorter than the branch.
          REQUIRE(length(test::vertex_of(part, i)) < 2.0 * model.length_m + 1.0);
        }
      }
    }
  }
}

TEST_CASE("the nearest model is found by angle and length") {
  const BranchLibrary library = BranchLibrary::build(test::shipped_presets().fallback());
  const auto at = [&](double angle_deg, double length_m) {
    const BranchModel& model = library.models()[library.nearest(kRadian * angle_deg, length_m)];
    return std::pair(model.angle_deg, std::round(10.0 * model.length_m));
  };
  CHECK(at(70, 2.0) == std::pair(70.0, 20.0));
  CHECK(at(74.9, 2.19) == std::pair(70.0, 20.0));
  CHECK(at(75.1, 2.21) == std::pair(80.0, 24.0));
  CHECK(at(12, 0.05) == std::pair(30.0, 4.0));
  CHECK(at(90, 9.0) == std::pair(90.0, 32.0));
}

TEST_CASE("placed models start and end where the tree's branches do") {
  const Preset& preset = test::shipped_presets().named("cunninghamia-lanceolata");
  const BranchLibrary library = BranchLibrary::build(preset);
  const test::Stages stages = test::stages_of(test::paper_tree_1(), preset);
  const auto placements = library.place(stages.skeleton);
  std::size_t branches = 0;
  for (const Axis& axis : stages.skeleton.axes) branches += axis.order == 1 ? 1 : 0;
  CHECK(placements.size() == branches);
  for (const BranchPlacement& placement : placements) {
    const auto points = stages.skeleton.points_of(stages.skeleton.axes[placement.axis]);
    const BranchModel& model = library.models()[placement.model];
    const double angle = kRadian * model.angle_deg;
    const Point tip{model.length_m * std::sin(angle), 0.0, model.length_m * std::cos(angle)};
    CHECK(length(placed(placement, {}) - points.front().at) < 1e-9);
    CHECK(length(placed(placement, tip) - points.back().at) < 1e-9);
    CHECK(stages.crown.excess_m(placed(placement, tip)) < 0.001);
    // Branches of this tree are 30 to 90 degrees from the vertical.
    CHECK(std::abs(placement.tilt_rad) <= 5.001 * kRadian);
  }
  // A quarter turn clockwise from north is east; up stays up.
  const BranchPlacement east{.scale = 2.0, .azimuth_rad = 90.0 * kRadian, .base = {1, 2, 3}};
  CHECK(length(placed(east, {1, 0, 0.5}) - Point{3, 2, 4}) < 1e-12);
  const BranchPlacement north{.azimuth_rad = 0.0};
  CHECK(length(placed(north, {1, 0.25, 0}) - Point{-0.25, 1, 0}) < 1e-12);
}
