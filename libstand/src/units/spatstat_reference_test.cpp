// SPDX-License-Identifier: MIT
// Neighbors, distances to the boundary, weights and Clark-Evans indices against those of spatstat
// 3.0, which tests/reference/stand/spatstat.R computed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/clark_evans.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"

using namespace silvafit::stand;
using silvafit::data::Table;
using silvafit::test::reference_data;

namespace {

/// A concave window with a hole, and 294 clustered points in it.
Window pattern_window() {
  return Window({{.outer = {{0, 0}, {60, 0}, {60, 40}, {35, 40}, {35, 22}, {0, 35}},
                  .holes = {{{12, 8}, {12, 16}, {20, 16}, {20, 8}}}}});
}

Table pattern() {
  return silvafit::data::read_csv_table(
      silvafit::test::source_file("tests/reference/stand/pattern.csv"));
}

std::vector<double> column(const Table& table, const std::string& name) {
  const std::span<const double> values = table.numbers(name);
  return {values.begin(), values.end()};
}

Inventory inventory_of(const Table& table) {
  Inventory inventory;
  inventory.x = column(table, "x");
  inventory.y = column(table, "y");
  inventory.dbh_cm = column(table, "dbh");
  inventory.cw_m = column(table, "cw");
  inventory.species = table.text("species");
  inventory.tree = table.labels("tree");
  for (std::size_t i = 0; i < inventory.size(); ++i) inventory.plot.append("1");
  return inventory;
}

double largest_difference(std::span<const double> expected, const std::vector<double>& found) {
  double largest = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    largest = std::max(largest, std::abs(expected[i] - found[i]));
  }
  return largest;
}

// The file is written with 12 digits; all values are below 100 but the areas.
constexpr double kWritten = 1e-10;

}  // namespace

TEST_CASE("clustered trees in a concave window with a hole have spatstat's neighbors") {
  const Table expected = pattern();
  const Inventory inventory = inventory_of(expected);
  StructuralUnitOptions options{
      .edge = EdgeCorrection::kHanisch,
      .windows = {{std::nullopt, pattern_window()}},
      .further = {
          FurtherIndex::kCrownOverlap, FurtherIndex::kDifferentiation, FurtherIndex::kHegyi}};
  const StructuralUnits units = structural_units(inventory, options);
  std::size_t wrong_neighbors = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto numbers = expected.numbers("nn" + std::to_string(k + 1));
    const auto distances = expected.numbers("d" + std::to_string(k + 1));
    for (std::size_t i = 0; i < inventory.size(); ++i) {
      if (units.nearest[4 * i + k] + 1 != numbers[i]) ++wrong_neighbors;
      CHECK(units.distance_m[4 * i + k] == Approx(distances[i]).margin(kWritten));
    }
  }
  CHECK(wrong_neighbors == 0);
  CHECK(largest_difference(expected.numbers("differentiation"), units.further[1].values) <
        kWritten);
  CHECK(largest_difference(expected.numbers("hegyi"), units.further[2].values) < 1e-8);
  // Discs of 2048 corners lack (2 pi / 2048)^2 / 6 = 1.6e-6 of their area.
  CHECK(largest_difference(expected.numbers("overlap"), units.further[0].values) < 1e-5);

  options.competition_radius_m = 6.0;
  const StructuralUnits by_radius = structural_units(inventory, options);
  CHECK(largest_difference(expected.numbers("hegyi6"), by_radius.further[2].values) < 1e-8);
}

TEST_CASE("Hanisch's core trees and weights are those of spatstat and Clipper") {
  const Table expected = pattern();
  const Inventory inventory = inventory_of(expected);
  const Window window = pattern_window();
  const StructuralUnits units = structural_units(
      inventory, {.edge = EdgeCorrection::kHanisch, .windows = {{std::nullopt, window}}});
  double weighted = 0.0;
  double weights = 0.0;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    CHECK(window.distance_to_boundary_m({inventory.x[i], inventory.y[i]}) ==
          Approx(expected.numbers("boundary")[i]).margin(kWritten));
    CHECK(units.core[i] == expected.numbers("keep")[i]);
    if (units.core[i] == 0) continue;
    // Arcs of 360 corners lack 5e-5 of their area; parabolas between 129 distances miss by less
    // than 1e-4 where an edge vanishes between two of them.
    CHECK(units.weight[i] ==
          Approx(window.area_m2() / expected.numbers("eroded")[i]).epsilon(1e-4));
    weighted += units.weight_of(i) * inventory.dbh_cm[i];
    weights += units.weight_of(i);
  }
  // patterns.json: pattern.hanisch_mean_dbh
  CHECK(weighted / weights == Approx(18.2666273090385).epsilon(1e-6));
}

TEST_CASE("distances on a torus are spatstat's periodic distances") {
  const Table expected = pattern();
  const Inventory inventory = inventory_of(expected);
  const StructuralUnits units =
      structural_units(inventory,
                       {.edge = EdgeCorrection::kTorus,
                        .windows = {{std::nullopt, Window::rectangle({0, 0}, {60, 40})}}});
  for (std::size_t k = 0; k < 4; ++k) {
    const auto distances = expected.numbers("torus" + std::to_string(k + 1));
    for (std::size_t i = 0; i < inventory.size(); ++i) {
      CHECK(units.distance_m[4 * i + k] == Approx(distances[i]).margin(kWritten));
    }
  }
}

TEST_CASE("the convex hull and the index of Clark and Evans are spatstat's") {
  const Inventory inventory = inventory_of(pattern());
  std::vector<Point> points;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    points.push_back({inventory.x[i], inventory.y[i]});
  }
  // patterns.json, written with 15 digits
  const Window hull = *Window::convex_hull(points);
  CHECK(hull.area_m2() == Approx(2134.3211885).epsilon(1e-12));
  CHECK(hull.perimeter_m() == Approx(182.673119831557).epsilon(1e-12));
  CHECK(pattern_window().area_m2() == Approx(1933.5).epsilon(1e-14));
  CHECK(pattern_window().perimeter_m() == Approx(247.336309405189).epsilon(1e-12));
  const ClarkEvans pattern = clark_evans(points, pattern_window());
  CHECK(pattern.mean_distance_m == Approx(0.991970296332261).epsilon(1e-12));
  CHECK(pattern.R == Approx(0.773624545316897).epsilon(1e-12));
}

TEST_CASE("public patterns have spatstat's Clark-Evans indices", "[reference]") {
  struct Case {
    const char* file;
    Window window;
    double R;
    double R_donnelly;
    double p;
  };
  // patterns.json, written with 15 digits
  const std::vector<Case> cases{{"longleaf.csv",
                                 Window::rectangle({0, 0}, {200, 200}),
                                 0.832054731186041,
                                 0.817679949858518,
                                 8.21565038222616e-15},
                                {"finpines.csv",
                                 Window::rectangle({-5, -8}, {5, 2}),
                                 0.889998023915703,
                                 0.856386168035709,
                                 0.0181675534029826}};
  for (const Case& one : cases) {
    const Table table = silvafit::data::read_csv_table(reference_data(one.file));
    std::vector<Point> points;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      points.push_back({table.numbers("x")[i], table.numbers("y")[i]});
    }
    const ClarkEvans found = clark_evans(points, one.window);
    CHECK(found.R == Approx(one.R).epsilon(1e-12));
    CHECK(found.R_donnelly == Approx(one.R_donnelly).epsilon(1e-12));
    // spatstat takes 1 - pnorm(z), which has no digits below 1e-16.
    CHECK(found.p == Approx(one.p).margin(1e-15));
  }
}
