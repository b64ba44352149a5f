// SPDX-License-Identifier: MIT
// Variants of U, C and W, and the further indices, by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "test_support/stand_test_support.hpp"
#include "units/unit_indices.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

StructuralUnitOptions with(std::vector<FurtherIndex> further, std::size_t neighbors = 2) {
  return {.neighbors = neighbors, .edge = EdgeCorrection::kNone, .further = std::move(further)};
}

/// A reference tree, a neighbor 3 m to the east and one 4 m to the north.
std::vector<Tree> corner() {
  return {{.dbh_cm = 20, .cw_m = 4, .h_m = 15},
          {.x = 3, .dbh_cm = 30, .cw_m = 3, .h_m = 12},
          {.y = 4, .dbh_cm = 10, .cw_m = 2, .h_m = 18}};
}

}  // namespace

TEST_CASE("U and T compare by dbh, height or crown width") {
  const Inventory stand = stand_of(corner());
  StructuralUnitOptions options = with({FurtherIndex::kDifferentiation});
  StructuralUnits units = structural_units(stand, options);
  CHECK(units.U[0] == 0.5);
  // 1 - 20/30 and 1 - 10/20
  CHECK(units.further.at(0).values[0] == Approx((1.0 / 3.0 + 0.5) / 2.0).epsilon(1e-15));
  options.size = SizeMeasure::kHeight;
  units = structural_units(stand, options);
  CHECK(units.U[1] == 1.0);
  CHECK(units.further[0].values[0] == Approx((3.0 / 15.0 + 3.0 / 18.0) / 2.0).epsilon(1e-15));
  options.size = SizeMeasure::kCrownWidth;
  units = structural_units(stand, options);
  CHECK(units.U[0] == 0.0);
  Inventory without_height = stand;
  without_height.h_m = {15, NAN, 18};
  options.size = SizeMeasure::kHeight;
  CHECK(std::isnan(structural_units(without_height, options).U[0]));
  without_height.h_m.clear();
  CHECK_THROWS_WITH(structural_units(without_height, options), Contains("compare trees by h"));
}

TEST_CASE("a neighbor without dbh counts for W, M and C, and makes U unknown") {
  Inventory stand = stand_of(corner());
  const StructuralUnits known = structural_units(stand, with({FurtherIndex::kHegyi}));
  stand.dbh_cm[1] = NAN;
  stand.neighbor_only = {0, 1, 0};
  const StructuralUnits units = structural_units(stand, with({FurtherIndex::kHegyi}));
  CHECK(units.W[0] == known.W[0]);
  CHECK(units.M[0] == known.M[0]);
  CHECK(units.C[0] == known.C[0]);
  CHECK(std::isnan(units.U[0]));
  CHECK(std::isnan(units.further.at(0).values[0]));
  CHECK(units.core == std::vector<char>{1, 0, 1});
}

TEST_CASE("Hegyi adds ratios of diameters over distances, of neighbors or within a radius") {
  std::vector<Tree> trees = corner();
  trees.push_back({.x = -5, .dbh_cm = 40});
  StructuralUnitOptions options = with({FurtherIndex::kHegyi});
  CHECK(structural_units(stand_of(trees), options).further.at(0).values[0] ==
        Approx(30.0 / 20.0 / 3.0 + 10.0 / 20.0 / 4.0).epsilon(1e-15));
  options.competition_radius_m = 5.0;
  CHECK(structural_units(stand_of(trees), options).further.at(0).values[0] ==
        Approx(0.5 + 0.125 + 2.0 / 5.0).epsilon(1e-15));
  options.competition_radius_m = 2.9;
  CHECK(structural_units(stand_of(trees), options).further.at(0).values[0] == 0.0);
  // Without limit at distance 0.
  trees.push_back({});
  CHECK(std::isnan(structural_units(stand_of(trees), options).further.at(0).values[0]));

  options = {.neighbors = 1,
             .buffer_m = 1.0,
             .windows = {{std::nullopt, Window::rectangle({-10, -10}, {10, 10})}},
             .further = {FurtherIndex::kHegyi},
             .competition_radius_m = 7.0};
  const StructuralUnits near_edge = structural_units(stand_of(corner()), options);
  REQUIRE(near_edge.notes.size() == 1);
  CHECK_THAT(near_edge.notes[0], Contains("competitors of 1 core trees"));
}

TEST_CASE("BAL adds the basal area of thicker trees inside the window") {
  const auto basal = [](double dbh) { return M_PI * dbh * dbh / 4e4; };
  const Inventory stand = stand_of({{.dbh_cm = 20},
                                    {.x = 1, .dbh_cm = 30},
                                    {.x = 2, .dbh_cm = 20},
                                    {.x = 3, .dbh_cm = 40},
                                    {.x = 99, .dbh_cm = 99}});
  StructuralUnitOptions options = with({FurtherIndex::kBasalAreaLarger}, 1);
  options.windows = {{std::nullopt, Window::rectangle({-10, -10}, {10, 10})}};
  const StructuralUnits units = structural_units(stand, options);
  const std::vector<double>& larger = units.further.at(0).values;
  const double hectares = 0.04;
  CHECK(larger[0] == Approx((basal(30) + basal(40)) / hectares).epsilon(1e-14));
  // Equal ones do not count.
  CHECK(larger[2] == larger[0]);
  CHECK(larger[1] == Approx(basal(40) / hectares).epsilon(1e-14));
  CHECK(larger[3] == 0.0);
  CHECK(std::isnan(larger[4]));
}

TEST_CASE("CCF is the crown area of open-grown trees in percent of the area") {
  const Inventory stand = stand_of({{.dbh_cm = 20, .species = "A"},
                                    {.x = 1, .dbh_cm = 30, .species = "B"},
                                    {.x = 2, .dbh_cm = 10, .species = "A", .plot = "b"},
                                    {.x = 3, .dbh_cm = 10, .species = "A", .plot = "b"}});
  StructuralUnitOptions options = with({FurtherIndex::kCrownCompetition}, 1);
  options.windows = {{kEveryPlot, Window::rectangle({-10, -10}, {10, 10})}};
  options.open_grown_crown = "ifelse(species == \"A\", 1 + 0.2*dbh, 6)";
  const StructuralUnits units = structural_units(stand, options);
  const std::vector<double>& factor = units.further.at(0).values;
  CHECK(factor[0] == Approx(100.0 * M_PI / 4.0 * (25.0 + 36.0) / 400.0).epsilon(1e-14));
  CHECK(factor[1] == factor[0]);
  CHECK(factor[3] == Approx(100.0 * M_PI / 4.0 * 18.0 / 400.0).epsilon(1e-14));
  options.open_grown_crown = "";
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("`open_grown`: CCF needs"));
  options.open_grown_crown = "1 + 0.2*d";
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("unknown column 'd'"));
  options.open_grown_crown = "-dbh";
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("is -20 m for dbh 20 cm"));
}

TEST_CASE("the area that two circles share is that of the closed form") {
  CHECK(shared_area_m2(1, 2, 3) == 0.0);
  CHECK(shared_area_m2(1, 2, 4) == 0.0);
  CHECK(shared_area_m2(1, 2, 0.5) == Approx(M_PI).epsilon(1e-15));
  CHECK(shared_area_m2(2, 1, 1) == Approx(M_PI).epsilon(1e-15));
  CHECK(shared_area_m2(1, 1, 0) == Approx(M_PI).epsilon(1e-15));
  // The lens of two unit circles through each other's centers.
  CHECK(shared_area_m2(1, 1, 1) == Approx(2.0 * M_PI / 3.0 - std::sqrt(3.0) / 2.0).epsilon(1e-14));
  // Radii 3 and 4, 5 m apart: the crossing is a right angle, so that the lens is two sectors less
  // the kite of area 12.
  const double lens = 9.0 * std::atan2(4.0, 3.0) + 16.0 * std::atan2(3.0, 4.0) - 12.0;
  CHECK(shared_area_m2(3, 4, 5) == Approx(lens).epsilon(1e-14));
  CHECK(shared_area_m2(4, 3, 5) == Approx(lens).epsilon(1e-14));
}

TEST_CASE("CO is the mean share of the crown that neighbors cover") {
  const Inventory stand = stand_of({{.cw_m = 2}, {.x = 1, .cw_m = 2}, {.x = -5, .cw_m = 2}});
  const StructuralUnits units = structural_units(stand, with({FurtherIndex::kCrownOverlap}));
  const double lens = 2.0 * M_PI / 3.0 - std::sqrt(3.0) / 2.0;
  CHECK(units.further.at(0).values[0] == Approx(lens / M_PI / 2.0).epsilon(1e-14));
  CHECK(units.C[0] == 0.5);
  Inventory missing = stand;
  missing.cw_m[1] = NAN;
  CHECK(std::isnan(
      structural_units(missing, with({FurtherIndex::kCrownOverlap})).further.at(0).values[0]));
}

TEST_CASE("C by facing radii uses the crown on the neighbor's side") {
  // 5 m to the north-east at (3, 4): the radius is that of a quarter ellipse with half axes 2
  // (east) and 1 (north), at the direction (0.6, 0.8): 2 / sqrt((1 * 0.6)^2 + (2 * 0.8)^2) = 1.17.
  Inventory stand = stand_of({{}, {.x = 3, .y = 4}});
  stand.cr_e_m = {2, 9};
  stand.cr_n_m = {1, 9};
  stand.cr_w_m = {9, 3};
  stand.cr_s_m = {9, 4};
  const double own = 2.0 / std::sqrt(0.36 + 2.56);
  const double other = 12.0 / std::sqrt(16.0 * 0.36 + 9.0 * 0.64);
  StructuralUnitOptions options = with({}, 1);
  options.reach = CrownReach::kFacingRadii;
  CHECK(structural_units(stand, options).C[0] == (own + other > 5.0 ? 1.0 : 0.0));
  // Just too short, though the crowns are wide on the other sides.
  const double scale = (5.0 - own) / other;
  stand.cr_w_m[1] *= 0.999 * scale;
  stand.cr_s_m[1] *= 0.999 * scale;
  CHECK(structural_units(stand, options).C[0] == 0.0);
  stand.cr_w_m[1] *= 1.002;
  stand.cr_s_m[1] *= 1.002;
  CHECK(structural_units(stand, options).C[0] == 1.0);
  stand.cr_w_m[1] = NAN;
  CHECK(std::isnan(structural_units(stand, options).C[0]));
  stand.cr_n_m.clear();
  CHECK_THROWS_WITH(structural_units(stand, options), Contains("facing` needs the columns"));
}

TEST_CASE("a crown without radii towards its neighbor does not reach it") {
  // The own crown has no half axis on the neighbor's side, or only one: no area, so no radius in
  // between. The neighbor's crown of 4.9 m alone is too short for 5 m, that of 5.1 m is not.
  Inventory stand = stand_of({{}, {.x = 3, .y = 4}});
  stand.cr_w_m = {4, 4.9};
  stand.cr_s_m = {4, 4.9};
  StructuralUnitOptions options = with({}, 1);
  options.reach = CrownReach::kFacingRadii;
  for (const auto& [east, north] : {std::pair{0.0, 0.0}, {9.0, 0.0}, {0.0, 9.0}}) {
    stand.cr_e_m = {east, 1};
    stand.cr_n_m = {north, 1};
    stand.cr_w_m[1] = stand.cr_s_m[1] = 4.9;
    CHECK(structural_units(stand, options).C[0] == 0.0);
    stand.cr_w_m[1] = stand.cr_s_m[1] = 5.1;
    CHECK(structural_units(stand, options).C[0] == 1.0);
    stand.cr_w_m[1] = stand.cr_s_m[1] = 0.0;
    CHECK(structural_units(stand, options).C == std::vector<double>{0.0, 0.0});
  }
}

TEST_CASE("species may have limit angles of their own") {
  // Neighbors to the north and at 80 degrees from it.
  std::vector<Tree> trees{
      {},
      {.y = 2},
      {.x = 3.0 * std::sin(80.0 * M_PI / 180.0), .y = 3.0 * std::cos(80.0 * M_PI / 180.0)}};
  StructuralUnitOptions options = with({});
  options.alpha0_deg = 72.0;
  CHECK(structural_units(stand_of(trees), options).W[0] == 0.0);
  options.alpha0_deg_of_species = {{"A", 90.0}};
  CHECK(structural_units(stand_of(trees), options).W[0] == 1.0);
  trees[0].species = "B";
  CHECK(structural_units(stand_of(trees), options).W[0] == 0.0);
  options.alpha0_deg_of_species = {{"Z", 90.0}};
  CHECK_THROWS_WITH(structural_units(stand_of(trees), options), Contains("unknown species 'Z'"));
  options.alpha0_deg_of_species = {{"A", 190.0}};
  CHECK_THROWS_WITH(structural_units(stand_of(trees), options), Contains("190 degrees"));
}

TEST_CASE("further indices are the last columns of the file, after the weights") {
  StructuralUnitOptions options = with({FurtherIndex::kHegyi, FurtherIndex::kDifferentiation}, 1);
  options.edge = EdgeCorrection::kHanisch;
  options.windows = {{std::nullopt, Window::rectangle({-8, -8}, {8, 8})}};
  const Inventory stand = stand_of({{.dbh_cm = 20}, {.x = 4, .dbh_cm = 10}});
  std::ostringstream csv;
  const StructuralUnits units = structural_units(stand, options);
  write_structural_units(stand, units, csv);
  CHECK(csv.str() ==
        "plot,tree,species,core,W,M,U,C,nn1,d1,weight,T,Hegyi\n"
        "1,1,A,1,,0,0,0,2,4,4,0.5,0.125\n"
        "1,2,A,0,,0,1,0,1,4,0,0.5,0.5\n");
  CHECK(summaries_of(stand, units).all().further == std::vector<double>{0.5, 0.125});
  CHECK(silvafit::find_word<FurtherIndex>("BAL") == FurtherIndex::kBasalAreaLarger);
  CHECK_FALSE(silvafit::find_word<FurtherIndex>("bal"));
}

TEST_CASE("turning, moving and shuffling a stand changes no further index") {
  const std::vector<Tree> trees = random_stand(300, 41);
  constexpr auto all = silvafit::all_values<FurtherIndex>();
  StructuralUnitOptions options = with({all.begin(), all.end()}, 4);
  options.competition_radius_m = 5.0;
  options.open_grown_crown = "1 + 0.2*dbh";
  // The hull turns with the trees.
  const StructuralUnits units = structural_units(stand_of(trees), options);
  std::vector<Tree> moved(trees.rbegin(), trees.rend());
  for (Tree& tree : moved) {
    const Tree old = tree;
    tree.x = 4e5 + std::cos(1.2) * old.x - std::sin(1.2) * old.y;
    tree.y = 5e6 + std::sin(1.2) * old.x + std::cos(1.2) * old.y;
  }
  const StructuralUnits same = structural_units(stand_of(moved), options);
  REQUIRE(same.further.size() == 5);
  for (std::size_t index = 0; index < 5; ++index) {
    for (std::size_t i = 0; i < trees.size(); ++i) {
      // Coordinates of millions of meters are rounded to 1e-9 m; Hegyi divides by decimeters.
      CHECK(same.further[index].values[trees.size() - 1 - i] ==
            Approx(units.further[index].values[i]).epsilon(1e-6).margin(1e-9));
    }
  }
}

TEST_CASE("BAL and CCF change no core tree, and a note states their area") {
  // Plot 1 has an area of 6 m2, plot 2 none.
  std::vector<Tree> trees = corner();
  trees.push_back({.x = 50, .species = "B", .plot = "2"});
  trees.push_back({.x = 51, .plot = "2"});
  const Inventory stand = stand_of(trees);
  const StructuralUnits plain = structural_units(stand, with({}, 1));
  CHECK(plain.core == std::vector<char>(5, 1));
  CHECK(plain.notes.empty());
  StructuralUnitOptions options =
      with({FurtherIndex::kBasalAreaLarger, FurtherIndex::kCrownCompetition}, 1);
  options.open_grown_crown = "dbh / 10";
  const StructuralUnits units = structural_units(stand, options);
  CHECK(units.core == plain.core);
  CHECK(summaries_of(stand, units).all().M == summaries_of(stand, plain).all().M);
  CHECK(summaries_of(stand, units).all().M == Approx(2.0 / 5.0));
  // The thinnest tree of plot 1: those of 20 and 30 cm on 6 m2.
  CHECK(units.further[0].values[2] == Approx(M_PI / 4.0 * (0.04 + 0.09) / 6e-4).epsilon(1e-14));
  CHECK(units.further[1].values[0] ==
        Approx(100.0 * M_PI / 4.0 * (4 + 9 + 1) / 6.0).epsilon(1e-14));
  CHECK(std::isnan(units.further[0].values[3]));
  REQUIRE(units.notes.size() == 2);
  CHECK_THAT(units.notes[0],
             Contains("BAL and CCF are too large") && Contains("convex hull of the trees of each"));
  CHECK_THAT(units.notes[1], Contains("missing in: 2"));

  // If the area of every plot is known, there is no assumption to report.
  options.plot_area_m2 = 500.0;
  const StructuralUnits known = structural_units(stand, options);
  CHECK(known.notes.empty());
  CHECK(known.further[0].values[2] == Approx(M_PI / 4.0 * 0.13 / 0.05).epsilon(1e-14));
  CHECK(known.further[1].values[3] == Approx(100.0 * M_PI / 4.0 * 8 / 500.0).epsilon(1e-14));
  // A given window has priority.
  options.windows = {{kEveryPlot, Window::rectangle({-10, -10}, {90, 10})}};
  CHECK(structural_units(stand, options).further[0].values[2] ==
        Approx(M_PI / 4.0 * 0.13 / 0.2).epsilon(1e-14));
}

TEST_CASE("an open-grown crown without limit is refused") {
  StructuralUnitOptions options = with({FurtherIndex::kCrownCompetition}, 1);
  options.open_grown_crown = "1/0";
  CHECK_THROWS_WITH(structural_units(stand_of(corner()), options),
                    Contains("`open_grown`") && Contains("is inf m"));
}
