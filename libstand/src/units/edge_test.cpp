// SPDX-License-Identifier: MIT
// Edge corrections beyond the buffer, and windows of many plots.
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

Window stand_window() { return Window::rectangle({0, 0}, {60, 40}); }

StructuralUnitOptions torus_options(std::size_t neighbors = 4) {
  return {.neighbors = neighbors,
          .edge = EdgeCorrection::kTorus,
          .windows = {{std::nullopt, stand_window()}}};
}

/// Moves around the torus.
double wrapped(double value, double length) { return value - length * std::floor(value / length); }

}  // namespace

TEST_CASE("Hanisch's core trees have all neighbors nearer than the boundary, and have weights") {
  // In a 10 x 20 m rectangle; distances to the boundary 5, 3, 1 and 5 m.
  const Inventory stand = stand_of({{.x = 5, .y = 10, .dbh_cm = 10},
                                    {.x = 7, .y = 10, .dbh_cm = 20},
                                    {.x = 1, .y = 5, .dbh_cm = 30},
                                    {.x = 5, .y = 15, .dbh_cm = 40}});
  const StructuralUnits units =
      structural_units(stand,
                       {.neighbors = 1,
                        .edge = EdgeCorrection::kHanisch,
                        .windows = {{std::nullopt, Window::rectangle({0, 0}, {10, 20})}}});
  // Neighbors at 2, 2, sqrt(41) and 5 m: the last is just as far as the boundary, which is not
  // nearer.
  CHECK(units.core == std::vector<char>{1, 1, 0, 0});
  // 200 m2 over (10 - 4) (20 - 4) m2
  CHECK(units.weight_of(0) == Approx(200.0 / 96.0).epsilon(1e-15));
  CHECK(units.weight_of(2) == 0.0);
  const UnitSummary all = summaries_of(stand, units).all();
  CHECK(all.core_trees == 2);
  CHECK(all.U == 0.5);
}

TEST_CASE("Hanisch's weights make means of random stands unbiased by distance") {
  // Small units are kept more often: unweighted, neighbors of core trees are too near. The mean
  // distance to the nearest neighbor of points at random is 0.5 / sqrt(density).
  const Inventory stand = stand_of(random_stand(3000, 21));
  const StructuralUnits units = structural_units(stand,
                                                 {.neighbors = 1,
                                                  .edge = EdgeCorrection::kHanisch,
                                                  .windows = {{std::nullopt, stand_window()}}});
  double sum = 0.0;
  double weights = 0.0;
  for (std::size_t i = 0; i < stand.size(); ++i) {
    const double weight = units.weight_of(i);
    weights += weight;
    if (weight > 0.0) sum += weight * units.distance_m[i];
  }
  const double expected = 0.5 * std::sqrt(2400.0 / 3000.0);
  // Standard error 0.26 / sqrt(3000 * 1.25) = 0.0043.
  CHECK(sum / weights == Approx(expected).margin(0.013));
  // The sum of the weights estimates the number of trees in the window.
  CHECK(weights == Approx(3000.0).epsilon(0.01));
}

TEST_CASE("Hanisch's weights are correct where a strip of the eroded window has just vanished") {
  // Two squares, of which one is just higher, at the ends of a strip of 20 m: a unit of 10.03 m in
  // the left one, among 400 small units in the strip.
  const Window window({{.outer = {{0, 0},
                                  {500, 0},
                                  {500, 20.4},
                                  {479.6, 20.4},
                                  {479.6, 20},
                                  {20.8, 20},
                                  {20.8, 20.8},
                                  {0, 20.8}}}});
  std::vector<Tree> trees{{.x = 10.4, .y = 10.4}, {.x = 10.4 + 10.03, .y = 10.4}};
  for (int i = 0; i < 400; ++i) trees.push_back({.x = 40.0 + i, .y = 8.0 + 0.01 * (i % 100)});
  const StructuralUnits units = structural_units(
      stand_of(trees),
      {.neighbors = 1, .edge = EdgeCorrection::kHanisch, .windows = {{std::nullopt, window}}});
  REQUIRE(units.core[0] == 1);
  REQUIRE(units.core[1] == 0);
  // What is left of the squares: rectangles less what lies within 10.03 m of the inner corners,
  // integral of sqrt(r^2 - u^2) over the heights u = 20 - y below the corner.
  const double r = 10.03;
  const auto integral = [r](double u) {
    return (u * std::sqrt(r * r - u * u) + r * r * std::asin(u / r)) / 2.0;
  };
  double area = 0.0;
  for (const double side : {20.8, 20.4}) {
    area += (side - r) * (side - 2.0 * r) - (integral(20.0 - r) - integral(20.0 - side + r));
  }
  // 10024.8 m2 over 8.7 m2; the corners of arcs take 5e-5 of an arc's area.
  CHECK(units.weight[0] == Approx(10024.8 / area).epsilon(2e-4));
  // A small unit in the strip: rectangles less 1 m on each side, 18.8 x 0.8 and 18.4 x 0.4 m on top
  // of the strip, and beside those less than 1 m2 at the inner corners.
  CHECK(units.weight[100] ==
        Approx(10024.8 / (498.0 * 18.0 + 18.8 * 0.8 + 18.4 * 0.4)).epsilon(1.0 / 9000.0));
}

TEST_CASE("a rectangle around trees in a national grid is a torus") {
  silvafit::Random random(11);
  for (int round = 0; round < 50; ++round) {
    const Point corner{random.uniform(2e5, 8e5), random.uniform(1e6, 9e6)};
    std::vector<Tree> trees(12);
    for (Tree& tree : trees) {
      tree = {.x = std::round(1e3 * (corner.x + random.uniform(0, 30))) / 1e3,
              .y = std::round(1e3 * (corner.y + random.uniform(0, 30))) / 1e3};
    }
    const StructuralUnits units =
        structural_units(stand_of(trees), {.edge = EdgeCorrection::kTorus});
    CHECK(units.core == std::vector<char>(trees.size(), 1));
  }
}

TEST_CASE("shifting a stand on a torus changes no index") {
  const std::vector<Tree> trees = random_stand(300, 31);
  const StructuralUnits units = structural_units(stand_of(trees), torus_options());
  silvafit::Random random(32);
  for (int round = 0; round < 5; ++round) {
    const double east = random.uniform(0, 60);
    const double north = random.uniform(0, 40);
    std::vector<Tree> moved = trees;
    for (Tree& tree : moved) {
      tree.x = wrapped(tree.x + east, 60);
      tree.y = wrapped(tree.y + north, 40);
    }
    const StructuralUnits same = structural_units(stand_of(moved), torus_options());
    CHECK(same.nearest == units.nearest);
    CHECK(same.W == units.W);
    CHECK(same.M == units.M);
    CHECK(same.U == units.U);
    CHECK(same.C == units.C);
    CHECK(same.core == std::vector<char>(trees.size(), 1));
  }
}

TEST_CASE("every tree of a lattice on a torus has the same unit") {
  std::vector<Tree> trees;
  for (int row = 0; row < 8; ++row) {
    for (int column = 0; column < 12; ++column) {
      trees.push_back({.x = 5.0 * column, .y = 5.0 * row});
    }
  }
  const StructuralUnits units = structural_units(stand_of(trees), torus_options());
  for (std::size_t i = 0; i < trees.size(); ++i) {
    CHECK(units.W[i] == 0.0);
    for (std::size_t k = 0; k < 4; ++k) CHECK(units.distance_m[4 * i + k] == 5.0);
  }
}

TEST_CASE("on a small torus each tree is a neighbor once, at its nearest image") {
  const Inventory stand = stand_of({{.x = 1, .y = 1}, {.x = 59, .y = 39}, {.x = 30, .y = 20}});
  const StructuralUnits units = structural_units(stand, torus_options(2));
  CHECK(units.nearest == std::vector<std::uint32_t>{1, 2, 0, 2, 0, 1});
  CHECK(units.distance_m[0] == Approx(std::sqrt(8.0)).epsilon(1e-14));
  CHECK(units.distance_m[1] == Approx(std::hypot(29.0, 19.0)).epsilon(1e-14));
  CHECK(std::isnan(structural_units(stand, torus_options(3)).W[0]));
}

TEST_CASE("a torus needs a rectangular window, one for all trees that are searched together") {
  const Inventory stand = stand_of({{.x = 1, .y = 1, .plot = "a"}, {.x = 2, .y = 1, .plot = "b"}});
  StructuralUnitOptions options{.neighbors = 1,
                                .edge = EdgeCorrection::kTorus,
                                .scope = SearchScope::kStand,
                                .windows = {{"a", Window::rectangle({0, 0}, {5, 5})},
                                            {"b", Window::rectangle({0, 0}, {5, 5})}}};
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("one window for the stand"));
  options.windows = {{std::nullopt, Window::circle({1, 1}, 5)}};
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("needs a rectangular window"));
  options.windows = {{std::nullopt, Window::rectangle({0, 0}, {5, 1.5})}};
  CHECK(structural_units(stand, options).nearest == std::vector<std::uint32_t>{1, 0});
  options.further = {FurtherIndex::kHegyi};
  options.competition_radius_m = 1.0;
  CHECK_THROWS_WITH(structural_units(stand, options),
                    Contains("more than half of the shorter side of the torus"));
  // Without a window the rectangle around the trees, not their hull.
  const Inventory three = stand_of({{.x = 0, .y = 0}, {.x = 9, .y = 1}, {.x = 4, .y = 8}});
  const StructuralUnits units =
      structural_units(three, {.neighbors = 1, .edge = EdgeCorrection::kTorus});
  CHECK_THAT(units.notes.at(0), Contains("no window is given; the rectangle around"));
}

TEST_CASE("trees outside of the window are not on the torus") {
  const Inventory stand = stand_of({{.x = 1, .y = 1}, {.x = 5, .y = 1}, {.x = -0.5, .y = 1}});
  const StructuralUnits units = structural_units(stand, torus_options(1));
  CHECK(units.nearest == std::vector<std::uint32_t>{1, 0, kNoTree});
  CHECK(units.core == std::vector<char>{1, 1, 0});
  CHECK_THAT(units.notes.at(0), Contains("1 tree is outside the window: ignored"));
}

TEST_CASE("a window for every plot is used in the coordinates of each plot") {
  const Inventory stand = stand_of({{.x = 1, .y = 0, .plot = "a"},
                                    {.x = 9, .y = 0, .plot = "a"},
                                    {.x = 0, .y = 2, .plot = "b"},
                                    {.x = 0, .y = 4, .plot = "b"}});
  const StructuralUnits units = structural_units(
      stand, {.neighbors = 1, .windows = {{kEveryPlot, Window::circle({0, 0}, 10)}}});
  CHECK(units.core == std::vector<char>{1, 0, 1, 1});
}

TEST_CASE("stems at one position and missing positions do not slow the search", "[slow]") {
  constexpr std::size_t kTrees = 100000;
  std::vector<Tree> trees;
  for (std::size_t i = 0; i < kTrees; ++i) {
    // A fifth at one position, a fifth very near it, a fifth without position, the rest at random.
    Tree tree{.x = 10, .y = 10};
    if (i % 5 == 1) tree.x += 1e-9 * static_cast<double>(i % 7);
    if (i % 5 == 2) tree.x = NAN;
    if (i % 5 > 2) {
      tree.x = static_cast<double>((i * 7919) % 1000) / 10.0;
      tree.y = static_cast<double>((i * 104729) % 1009) / 10.0;
    }
    trees.push_back(tree);
  }
  const Inventory stand = stand_of(trees);
  const auto start = std::chrono::steady_clock::now();
  StructuralUnitOptions options = without_edge();
  options.threads = 1;
  const StructuralUnits units = structural_units(stand, options);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  // Ids in the order of the rows: the first trees of the place are everyone's neighbors there.
  CHECK(units.nearest[0] == 1);
  CHECK(units.nearest[std::size_t{4} * 99995] == 0);
  CHECK(units.nearest[std::size_t{4} * 2] == kNoTree);
  // Compared pair by pair, 40,000 stems at one place would take minutes.
  CHECK(elapsed.count() < 20.0);
}
