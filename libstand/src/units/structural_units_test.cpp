// SPDX-License-Identifier: MIT
#include "silvafit/stand/structural_units.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

/// Ids of a tree's neighbors, nearest first.
std::vector<std::string> neighbors_of(const Inventory& inventory,
                                      const StructuralUnits& units,
                                      std::size_t tree) {
  std::vector<std::string> ids;
  for (std::size_t i = 0; i < units.neighbors; ++i) {
    const std::uint32_t neighbor = units.nearest[tree * units.neighbors + i];
    ids.emplace_back(neighbor == kNoTree ? "none" : inventory.tree[neighbor]);
  }
  return ids;
}

using Ids = std::vector<std::string>;

bool same(const std::vector<double>& left, const std::vector<double>& right) {
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (left[i] != right[i] && !(std::isnan(left[i]) && std::isnan(right[i]))) return false;
  }
  return left.size() == right.size();
}

}  // namespace

TEST_CASE("a unit of five trees has the indices computed by hand") {
  // Neighbors to the north 1 m, east 2 m, south 3 m, and north-north-east; azimuths 0, 90, 180 and
  // atan(1/3) = 18.4 degrees: angles 18.4, 71.6, 90, 180, two of them below 72.
  const Inventory stand =
      stand_of({{.x = 0, .y = 0, .dbh_cm = 20, .species = "A", .cw_m = 2.0},
                {.x = 0, .y = 1, .dbh_cm = 20, .species = "A", .cw_m = 0.1},
                {.x = 2, .y = 0, .dbh_cm = 19.9, .species = "B", .cw_m = 2.0},
                {.x = 0, .y = -3, .dbh_cm = 35, .species = "C", .cw_m = 4.1},
                {.x = 1.5, .y = 4.5, .dbh_cm = 5, .species = "A", .cw_m = 9.0}});
  const StructuralUnits units = structural_units(stand, without_edge());
  CHECK(neighbors_of(stand, units, 0) == Ids{"2", "3", "4", "5"});
  CHECK(units.W[0] == 0.5);
  CHECK(units.M[0] == 0.5);
  CHECK(units.U[0] == 0.5);
  // Reaches 1.05 > 1, 2.0 = 2 (touching is no overlap), 3.05 > 3, 5.5 > 4.74.
  CHECK(units.C[0] == 0.75);
  CHECK(units.distance_m[3] == Approx(std::sqrt(22.5)).epsilon(1e-15));
  CHECK(units.core == std::vector<char>{1, 1, 1, 1, 1});
}

TEST_CASE("in a square lattice the inner trees have W 0 and touching crowns do not overlap") {
  std::vector<Tree> trees;
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      // A spacing without an exact binary value: ties must not depend on rounding.
      trees.push_back({.x = 0.3 + 1.7 * column, .y = 0.7 + 1.7 * row, .cw_m = 1.7});
    }
  }
  const Inventory stand = stand_of(trees);
  const StructuralUnits units = structural_units(stand, {.buffer_m = 1.7});
  int inner = 0;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const bool is_inner = i / 9 >= 1 && i / 9 <= 7 && i % 9 >= 1 && i % 9 <= 7;
    // Trees at exactly the buffer's width from the bounding rectangle are core trees.
    CHECK((units.core[i] != 0) == is_inner);
    if (!is_inner) continue;
    ++inner;
    CHECK(units.W[i] == 0.0);
    CHECK(units.U[i] == 1.0);
    CHECK(units.M[i] == 0.0);
    CHECK(units.C[i] == 0.0);
    const std::size_t id = i + 1;
    CHECK(neighbors_of(stand, units, i) == Ids{std::to_string(id - 9),
                                               std::to_string(id - 1),
                                               std::to_string(id + 1),
                                               std::to_string(id + 9)});
  }
  CHECK(inner == 49);
  // At a limit of 90 degrees the right angles are not smaller; just above they all are.
  CHECK(structural_units(stand, {.alpha0_deg = 90.0}).W[40] == 0.0);
  CHECK(structural_units(stand, {.alpha0_deg = 90.001}).W[40] == 1.0);
}

TEST_CASE("a regular pentagon has angles of just 72 degrees, which are not smaller") {
  for (const double turn : {0.0, 0.1, 1.0, 2.5}) {
    std::vector<Tree> trees{{}};
    for (int i = 0; i < 5; ++i) {
      const double azimuth = turn + 2.0 * M_PI * i / 5.0;
      trees.push_back({.x = 3.0 * std::sin(azimuth), .y = 3.0 * std::cos(azimuth)});
    }
    StructuralUnitOptions options = without_edge(5);
    options.alpha0_deg = 72.0;
    CHECK(structural_units(stand_of(trees), options).W[0] == 0.0);
    options.alpha0_deg = std::nullopt;  // 360 / (5 + 1)
    CHECK(structural_units(stand_of(trees), options).alpha0_deg == 60.0);
  }
}

TEST_CASE("angles and crowns at the limit are at the limit in a national grid, too") {
  struct Case {
    double east, north;
  };
  silvafit::Random random(3);
  std::vector<Case> corners{{0, 0}, {600000.35, 5500000.15}, {0, 9000000.15}, {-19999999.9, 0.05}};
  for (int i = 0; i < 200; ++i) {
    corners.push_back({random.uniform(-2e7, 2e7), random.uniform(-2e7, 2e7)});
  }
  for (const Case& corner : corners) {
    CAPTURE(corner.east, corner.north);
    // Around tree 1 the corners of a square: angles of just 90 degrees, the limit of n = 3. Its
    // crown touches those of trees 2 to 4, 2.3 * sqrt(2) m away.
    const double at = 2.3;
    const double width = at * std::sqrt(2.0);
    std::vector<Tree> trees{{.x = at, .y = at, .cw_m = width},
                            {.cw_m = width},
                            {.x = 4.6, .cw_m = width},
                            {.y = 4.6, .cw_m = width}};
    for (Tree& tree : trees) {
      tree.x += corner.east;
      tree.y += corner.north;
    }
    const StructuralUnits square = structural_units(stand_of(trees), without_edge(3));
    CHECK(square.W[0] == 0.0);
    CHECK(square.C[0] == 0.0);

    // In a row to the north, crowns touch; a tree 1 mm nearer overlaps, and 1 mm of 2.3 m less
    // than a right angle is smaller.
    const StructuralUnits row = structural_units(
        stand_of({{.x = corner.east, .y = corner.north, .cw_m = 2.3},
                  {.x = corner.east, .y = corner.north + 2.3, .cw_m = 2.3},
                  {.x = corner.east + 2.299, .y = corner.north + 0.001, .cw_m = 2.3}}),
        {.neighbors = 2, .alpha0_deg = 90.0, .edge = EdgeCorrection::kNone});
    CHECK(row.C[0] == 0.5);
    CHECK(row.W[0] == 1.0);
  }
}

TEST_CASE("a crown due north is neither to the east nor to the west, also in a national grid") {
  const double same_x = std::nextafter(500000.3, 6e6);
  Inventory stand = stand_of({{.x = same_x, .y = 5500000}, {.x = 500000.3, .y = 5500003}});
  stand.cr_n_m = {2.0, NAN};
  stand.cr_s_m = {NAN, 1.5};
  stand.cr_e_m = {NAN, NAN};
  stand.cr_w_m = {NAN, NAN};
  StructuralUnitOptions options = without_edge(1);
  options.reach = CrownReach::kFacingRadii;
  const StructuralUnits units = structural_units(stand, options);
  CHECK(units.C[0] == 1.0);
  CHECK(units.C[1] == 1.0);
}

TEST_CASE("stems whose positions differ only by rounding have one position") {
  const double x = std::nextafter(600000.3, 6e6);
  const Inventory stand = stand_of(
      {{.x = 600000.3, .y = 5500000}, {.x = x, .y = 5500000}, {.x = 600002, .y = 5500003}});
  StructuralUnitOptions options = without_edge(2);
  options.further = {FurtherIndex::kHegyi};
  const StructuralUnits units = structural_units(stand, options);
  CHECK(std::isnan(units.W[0]));
  CHECK(std::isnan(units.further[0].values[0]));
  CHECK(units.further[0].values[2] == Approx(2.0 / std::hypot(1.7, 3.0)).epsilon(1e-8));
}

TEST_CASE("clustered neighbors on one side have W of three quarters and more") {
  // All neighbors within 60 degrees: three small angles, and the rest of the circle taken <= 180.
  const Inventory stand =
      stand_of({{}, {.x = 0, .y = 2}, {.x = 1, .y = 2}, {.x = 2, .y = 2}, {.x = 2, .y = 1.2}});
  CHECK(structural_units(stand, without_edge()).W[0] == 1.0);
  const Inventory line = stand_of({{}, {.x = 1}, {.x = 2}, {.x = -1}, {.x = -2}});
  CHECK(structural_units(line, without_edge()).W[0] == 0.5);
}

TEST_CASE("ties in distance go to the smaller id, integers by value") {
  const Inventory stand = stand_of({{.id = "100"},
                                    {.x = 1, .id = "10"},
                                    {.y = 1, .id = "9"},
                                    {.x = -1, .id = "b"},
                                    {.y = -1, .id = "a"},
                                    {.x = 0.5, .id = "77"}});
  const StructuralUnits units = structural_units(stand, without_edge(3));
  CHECK(neighbors_of(stand, units, 0) == Ids{"77", "9", "10"});
  CHECK(neighbors_of(stand, structural_units(stand, without_edge(4)), 0) ==
        Ids{"77", "9", "10", "a"});
}

TEST_CASE("many ties are decided by id, wherever the trees stand in the file") {
  std::vector<Tree> trees;
  for (int i = 60; i > 0; --i) {
    const double azimuth = 2.0 * M_PI * ((7 * i) % 60) / 60.0;
    trees.push_back({.x = 500000.3 + 10.0 * std::sin(azimuth),
                     .y = 6000000.7 + 10.0 * std::cos(azimuth),
                     .id = std::to_string(i)});
  }
  trees.push_back({.x = 500000.3, .y = 6000000.7, .id = "999"});
  const Inventory stand = stand_of(trees);
  CHECK(neighbors_of(stand, structural_units(stand, without_edge(6)), 60) ==
        Ids{"1", "2", "3", "4", "5", "6"});
}

TEST_CASE("stems at one place are neighbors without a direction") {
  std::vector<Tree> trees;
  trees.reserve(10);
  for (int i = 0; i < 9; ++i) trees.push_back({.dbh_cm = 10.0 + i});
  trees.push_back({.x = 3});
  const Inventory stand = stand_of(trees);
  const StructuralUnits units = structural_units(stand, without_edge());
  CHECK(neighbors_of(stand, units, 4) == Ids{"1", "2", "3", "4"});
  CHECK(std::isnan(units.W[4]));
  CHECK(units.U[4] == 0.0);
  CHECK(units.C[4] == 1.0);
  CHECK(units.distance_m[std::size_t{4} * 4] == 0.0);
  CHECK(neighbors_of(stand, units, 9) == Ids{"1", "2", "3", "4"});
  CHECK(units.W[9] == 1.0);
  REQUIRE(units.notes.size() == 1);
  CHECK_THAT(units.notes[0], Contains("9 trees have a neighbor at the same position"));
}

TEST_CASE("too few neighbors, no species or no crown width give missing values") {
  const Inventory three = stand_of({{}, {.x = 1}, {.x = 2}});
  const StructuralUnits few = structural_units(three, without_edge());
  CHECK(neighbors_of(three, few, 0) == Ids{"2", "3", "none", "none"});
  CHECK(std::isnan(few.U[0]));
  CHECK(std::isnan(few.distance_m[2]));
  CHECK_THAT(few.notes.at(0), Contains("3 trees have fewer than 4 neighbors"));

  Inventory stand = stand_of({{}, {.x = 1, .species = nullptr}, {.x = 3, .cw_m = NAN}, {.x = 6}});
  const StructuralUnits units = structural_units(stand, without_edge(1));
  CHECK(std::isnan(units.W[0]));
  CHECK(std::isnan(units.M[0]));
  CHECK(units.U[0] == 1.0);
  CHECK(units.C[0] == 0.0);
  CHECK(std::isnan(units.C[3]));
  stand.cw_m.clear();
  CHECK(structural_units(stand, without_edge(1)).C.empty());
  CHECK(structural_units(stand_of({{}}), without_edge(1)).nearest[0] == kNoTree);
}

TEST_CASE("per plot neighbors are of the plot, per stand of all plots") {
  const Inventory stand = stand_of({{.id = "1", .plot = "a"},
                                    {.x = 1, .id = "1", .plot = "b"},
                                    {.x = 2, .id = "2", .plot = "a"}});
  StructuralUnitOptions options = without_edge(1);
  CHECK(structural_units(stand, options).nearest == std::vector<std::uint32_t>{2, kNoTree, 0});
  options.scope = SearchScope::kStand;
  const StructuralUnits units = structural_units(stand, options);
  // Trees 0 and 2 are equally near to tree 1; the smaller id is that of tree 0.
  CHECK(units.nearest == std::vector<std::uint32_t>{1, 0, 1});
  std::ostringstream csv;
  write_structural_units(stand, units, csv);
  CHECK(csv.str() ==
        "plot,tree,species,core,W,M,U,C,nn1,d1\n"
        "a,1,A,1,,0,1,0,b-1,1\n"
        "b,1,A,1,,0,1,0,a-1,1\n"
        "a,2,A,1,,0,1,0,b-1,1\n");
}

TEST_CASE("rotation, translation and another order of rows change no index") {
  const std::vector<Tree> trees = random_stand(400, 5);
  const StructuralUnits units = structural_units(stand_of(trees), without_edge());
  silvafit::Random random(6);
  for (int round = 0; round < 5; ++round) {
    const double turn = random.uniform(0, 2.0 * M_PI);
    std::vector<Tree> moved = trees;
    for (Tree& tree : moved) {
      const Tree old = tree;
      tree.x = 3.5e5 + std::cos(turn) * old.x - std::sin(turn) * old.y;
      tree.y = 6.7e6 + std::sin(turn) * old.x + std::cos(turn) * old.y;
    }
    const StructuralUnits same_units = structural_units(stand_of(moved), without_edge());
    CHECK(same_units.nearest == units.nearest);
    CHECK(same(same_units.W, units.W));
    CHECK(same(same_units.C, units.C));
  }

  std::vector<std::size_t> order(trees.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[random.below(i + 1)]);
  std::vector<Tree> shuffled;
  shuffled.reserve(order.size());
  for (const std::size_t i : order) shuffled.push_back(trees[i]);
  const Inventory stand = stand_of(shuffled);
  const StructuralUnits other = structural_units(stand, without_edge());
  for (std::size_t i = 0; i < order.size(); ++i) {
    CHECK(other.W[i] == units.W[order[i]]);
    CHECK(other.M[i] == units.M[order[i]]);
    CHECK(other.U[i] == units.U[order[i]]);
    CHECK(other.C[i] == units.C[order[i]]);
  }
}

TEST_CASE("the nearest neighbors are those of a comparison with every tree") {
  const std::vector<Tree> trees = random_stand(300, 9);
  const Inventory stand = stand_of(trees);
  const StructuralUnits units = structural_units(stand, without_edge(7));
  for (std::size_t i = 0; i < trees.size(); ++i) {
    std::vector<std::pair<double, std::uint32_t>> all;
    for (std::size_t j = 0; j < trees.size(); ++j) {
      if (j == i) continue;
      all.emplace_back(std::hypot(trees[j].x - trees[i].x, trees[j].y - trees[i].y),
                       static_cast<std::uint32_t>(j));
    }
    std::sort(all.begin(), all.end());
    for (std::size_t k = 0; k < 7; ++k) CHECK(units.nearest[7 * i + k] == all[k].second);
  }
}

TEST_CASE("in a random stand the mean of W is near one half") {
  // The mean of W in stands placed at random is about 0.5 (Hui and Gadow 2002: 0.475 to 0.517).
  const Inventory stand = stand_of(random_stand(4000, 11));
  const StructuralUnits units = structural_units(stand, {.buffer_m = 2.0});
  const UnitSummary all = summaries_of(stand, units).all();
  CHECK(all.trees == 4000);
  CHECK(all.core_trees > 3000);
  CHECK(all.W == Approx(0.5).margin(0.02));
  // Three species in equal shares: a neighbor is another one with probability 2/3.
  CHECK(all.M == Approx(2.0 / 3.0).margin(0.02));
  std::size_t sum = 0;
  for (const UnitSummary& species : summaries_of(stand, units).by_species()) sum += species.trees;
  CHECK(sum == 4000);
}

TEST_CASE("windows belong to plots, and missing ones are an error") {
  const Inventory stand = stand_of({{.x = 1, .y = 5, .plot = "a"},
                                    {.x = 5, .y = 5, .plot = "a"},
                                    {.x = 15, .y = 5, .plot = "b"},
                                    {.x = 25, .y = 5, .plot = "b"}});
  const Window left = Window::rectangle({0, 0}, {10, 10});
  const Window right = Window::rectangle({10, 0}, {20, 10});
  StructuralUnitOptions options{.neighbors = 1, .windows = {{"a", left}, {"b", right}}};
  const StructuralUnits units = structural_units(stand, options);
  CHECK(units.core == std::vector<char>{0, 1, 1, 0});
  CHECK_THAT(units.notes.at(0), Contains("1 tree is outside the window"));
  options.edge = EdgeCorrection::kNone;
  CHECK(structural_units(stand, options).core == std::vector<char>{1, 1, 1, 0});

  options.windows = {{"a", left}};
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("no window for plot b"));
  options.windows = {{std::nullopt, left}};
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("use `per=stand`"));
  options.scope = SearchScope::kStand;
  CHECK(structural_units(stand, options).core == std::vector<char>{1, 1, 0, 0});
  options.windows = {{std::nullopt, Window::rectangle({100, 0}, {110, 10})}};
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("all trees are outside the window"));
}

TEST_CASE("a note names overlapping plots in a stand, with the remedy") {
  // Three plots of 10 x 10 m, each in coordinates of its own.
  std::vector<Tree> trees;
  for (const char* plot : {"a", "b", "c"}) {
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {0.0, 10.0}}) {
      trees.push_back({.x = x, .y = y, .plot = plot});
    }
  }
  const auto overlap_note = [](const std::vector<Tree>& of, const StructuralUnitOptions& options) {
    for (const std::string& note : structural_units(stand_of(of), options).notes) {
      if (note.find("overlap") != std::string::npos) return note;
    }
    return std::string();
  };
  StructuralUnitOptions options = without_edge(1);
  CHECK(overlap_note(trees, options).empty());
  options.scope = SearchScope::kStand;
  // By hulls, whatever the window of the stand is.
  CHECK_THAT(overlap_note(trees, options),
             Contains("3 plots overlap, for example a and ") && Contains("use `per=plot`"));
  options.windows = {{std::nullopt, Window::rectangle({0, 0}, {40, 10})}};
  CHECK_THAT(overlap_note(trees, options), Contains("3 plots overlap"));
  options.windows = {{kEveryPlot, Window::circle({5, 5}, 8)}};
  CHECK_THAT(overlap_note(trees, options), Contains("3 plots overlap"));
  // By windows of their own, of which two share a strip.
  options.windows = {{"a", Window::rectangle({0, 0}, {10, 10})},
                     {"b", Window::rectangle({9, 0}, {19, 10})},
                     {"c", Window::rectangle({0, 10}, {10, 20})}};
  CHECK_THAT(overlap_note(trees, options),
             Contains("2 plots overlap, for example a and b") && Contains("`per=plot`"));
  // Side by side, with corners that differ by a millimeter.
  options.windows[1] = {"b", Window::rectangle({9.999, 0}, {19, 10})};
  CHECK(overlap_note(trees, options).empty());
  options.windows.clear();
  for (Tree& tree : trees) tree.x += tree.plot[0] == 'a' ? 0.0 : tree.plot[0] == 'b' ? 10.0 : 20.0;
  CHECK(overlap_note(trees, options).empty());
}

TEST_CASE("a note names a plot whose trees are all outside of its window") {
  const Inventory stand = stand_of({{.x = 1, .y = 1, .plot = "a"},
                                    {.x = 2, .y = 1, .plot = "a"},
                                    {.x = 101, .y = 1, .plot = "07"},
                                    {.x = 102, .y = 1, .plot = "07"}});
  StructuralUnitOptions options{.neighbors = 1,
                                .edge = EdgeCorrection::kHanisch,
                                .windows = {{kEveryPlot, Window::circle({0, 0}, 5)}}};
  const StructuralUnits units = structural_units(stand, options);
  CHECK(units.core == std::vector<char>{1, 1, 0, 0});
  CHECK_THAT(units.notes.at(1), Contains("all trees are outside the window of plot 07"));
  // With every correction it is an error if this is so of all plots.
  options.windows = {{kEveryPlot, Window::circle({0, 0}, 1)}};
  for (const EdgeCorrection edge : {EdgeCorrection::kNone,
                                    EdgeCorrection::kBuffer,
                                    EdgeCorrection::kHanisch,
                                    EdgeCorrection::kTorus}) {
    options.edge = edge;
    if (edge == EdgeCorrection::kTorus) {
      options.windows = {{kEveryPlot, Window::rectangle({3, 3}, {4, 4})}};
    }
    CHECK_THROWS_AS(structural_units(stand, options), silvafit::InputError);
    CHECK_THROWS_WITH(structural_units(stand, options),
                      Contains("all trees are outside the window") && Contains("x 1 and 102"));
  }
}

TEST_CASE("windows without an area are refused, and trees on one line have none") {
  CHECK_THROWS_AS(Window::rectangle({1, 1}, {1, 5}), silvafit::GeometryError);
  CHECK_THROWS_AS(Window({{.outer = {{0, 0}, {5, 5}, {9, 9}}}}), silvafit::GeometryError);
  const Inventory stand = stand_of({{.x = 512345.1, .y = 6e6 + 0.1},
                                    {.x = 512345.2, .y = 6e6 + 0.2},
                                    {.x = 512345.3, .y = 6e6 + 0.3}});
  for (const EdgeCorrection edge : {EdgeCorrection::kBuffer, EdgeCorrection::kHanisch}) {
    for (const SearchScope scope : {SearchScope::kPlot, SearchScope::kStand}) {
      const StructuralUnits units =
          structural_units(stand, {.neighbors = 1, .edge = edge, .scope = scope});
      CHECK(units.core == std::vector<char>{0, 0, 0});
      std::string notes;
      for (const std::string& note : units.notes) notes += note + "\n";
      CHECK_THAT(notes,
                 Contains("trees on one line have no convex hull, so there is no core tree"));
    }
  }
}

TEST_CASE("without a window the convex hull is used, with a note") {
  // A triangle of 20 by 20 m: (5, 5) is 5 m from two sides and (10, 10) on the third.
  std::vector<Tree> trees{
      {.x = 0, .y = 0}, {.x = 20}, {.y = 20}, {.x = 5, .y = 5}, {.x = 10, .y = 10}};
  trees.push_back({.x = 1, .plot = "line"});
  trees.push_back({.x = 2, .plot = "line"});
  const StructuralUnits units = structural_units(stand_of(trees), {.neighbors = 1});
  CHECK(units.core == std::vector<char>{0, 0, 0, 1, 0, 0, 0});
  CHECK_THAT(units.notes.at(0), Contains("no window is given; the convex hull"));
  CHECK_THAT(units.notes.at(1), Contains("no core tree in: line"));
}

TEST_CASE("of very many ties the first in the order of the trees are neighbors") {
  constexpr std::size_t kCount = 30000;
  constexpr double kRadius = 400.0;
  for (const EdgeCorrection edge : {EdgeCorrection::kNone, EdgeCorrection::kTorus}) {
    // The last tree is nearest; all others are on a circle around the first.
    std::vector<Tree> trees{{.x = 0.0, .y = 0.0, .id = "center"}};
    for (std::size_t i = 0; i < kCount; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / kCount;
      trees.push_back({.x = kRadius * std::cos(angle),
                       .y = kRadius * std::sin(angle),
                       .id = std::to_string(kCount - i)});
    }
    trees.push_back({.x = 300.0, .id = "near"});
    StructuralUnitOptions options{.edge = edge};
    if (edge == EdgeCorrection::kTorus) {
      options.windows = {{std::nullopt, Window::rectangle({-1000, -1000}, {1000, 1000})}};
    }
    const Inventory stand = stand_of(trees);
    const StructuralUnits units = structural_units(stand, options);
    CHECK(neighbors_of(stand, units, 0) == Ids{"near", "1", "2", "3"});
  }
}

TEST_CASE("options out of range are refused") {
  const Inventory stand = stand_of({{}, {.x = 1}});
  CHECK_THROWS_WITH(structural_units(stand, {.neighbors = 0}), Contains("`neighbors`: 0"));
  CHECK_THROWS_WITH(structural_units(stand, {.alpha0_deg = 181.0}), Contains("`alpha`: 181"));
  CHECK_THROWS_WITH(structural_units(stand, {.buffer_m = -1.0}), Contains("`buffer`: -1"));
  Inventory unplaced = stand;
  unplaced.x.clear();
  CHECK_THROWS_AS(structural_units(unplaced, {}), silvafit::UsageError);
}
