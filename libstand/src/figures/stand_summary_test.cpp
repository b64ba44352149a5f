// SPDX-License-Identifier: MIT
// Figures of plots, diameter classes and strata, against values worked out by hand.
#include "silvafit/stand/stand_summary.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

TEST_CASE("stand figures are those computed by hand") {
  Inventory stand = stand_of({{.dbh_cm = 10, .cw_m = 2, .h_m = 8},
                              {.dbh_cm = 20, .cw_m = 4, .h_m = 16},
                              {.dbh_cm = 30, .cw_m = 6, .h_m = 21},
                              {.dbh_cm = 30, .cw_m = 5, .h_m = 24}});
  // 200 m2, so that 100 trees a hectare are 2.
  const StandFigures figures = stand_figures(stand, all_rows(stand), 200.0);
  CHECK(figures.trees == 4);
  CHECK(figures.area_ha == 0.02);
  CHECK(figures.stems_per_ha == Approx(200.0).epsilon(1e-14));
  const double basal = basal_area_m2(10) + basal_area_m2(20) + 2 * basal_area_m2(30);
  CHECK(figures.basal_area_m2_per_ha == Approx(basal / 0.02).epsilon(1e-14));
  CHECK(figures.mean_dbh_cm == 22.5);
  CHECK(figures.sd_dbh_cm == Approx(std::sqrt(275.0 / 3.0)).epsilon(1e-14));
  CHECK(figures.quadratic_mean_dbh_cm == Approx(std::sqrt(2300.0 / 4.0)).epsilon(1e-14));
  CHECK(figures.mean_height_m == 17.25);
  CHECK(figures.lorey_height_m ==
        Approx((100 * 8 + 400 * 16 + 900 * 21 + 900 * 24) / 2300.0).epsilon(1e-14));
  CHECK(figures.dominant_height_m == 22.5);
  CHECK(stand_figures(stand, all_rows(stand), 100.0).dominant_height_m == 24.0);
  CHECK(figures.crown_cover_percent ==
        Approx(100.0 * M_PI / 4.0 * (4 + 16 + 36 + 25) / 200.0).epsilon(1e-14));
  // A thick tree without height is one of the thickest trees, but is not in the mean.
  stand.h_m[3] = NAN;
  CHECK(stand_figures(stand, all_rows(stand), 200.0).dominant_height_m == 21.0);
  const StandFigures nothing = stand_figures(stand, {}, 200.0);
  CHECK(nothing.stems_per_ha == 0.0);
  CHECK(std::isnan(nothing.quadratic_mean_dbh_cm));
  CHECK(std::isnan(nothing.dominant_height_m));
}

TEST_CASE("diameter classes begin at their lower limit") {
  const Inventory stand =
      stand_of({{.dbh_cm = 7.9}, {.dbh_cm = 8.0}, {.dbh_cm = 11.9}, {.dbh_cm = 16.3}});
  const auto classes = diameter_distribution(stand, all_rows(stand), 1e4, 4.0);
  REQUIRE(classes.size() == 4);
  CHECK(classes[0].low_cm == 4.0);
  CHECK(classes[0].trees == 1);
  CHECK(classes[1].trees == 2);
  CHECK(classes[2].trees == 0);
  CHECK(classes[3].trees == 1);
  CHECK(classes[3].high_cm == 20.0);
  CHECK(classes[1].basal_area_m2_per_ha ==
        Approx(basal_area_m2(8) + basal_area_m2(11.9)).epsilon(1e-14));
  // 0.3 is just below three tenths in binary numbers.
  const Inventory small = stand_of({{.dbh_cm = 0.3}});
  CHECK(diameter_distribution(small, all_rows(small), 1e4, 0.1)[0].low_cm ==
        Approx(0.3).epsilon(1e-14));
  CHECK_THROWS_WITH(diameter_distribution(stand, all_rows(stand), 1e4, 0.0),
                    Contains("`class_width`"));
  CHECK_THROWS_WITH(diameter_distribution(stand, all_rows(stand), 1e4, 1e-6),
                    Contains("too narrow"));
  // Equal diameters need one class, but not one whose number is beyond the whole numbers.
  const Inventory equal = stand_of({{.dbh_cm = 20.0}, {.dbh_cm = 20.0}});
  CHECK_THROWS_WITH(diameter_distribution(equal, all_rows(equal), 1e4, 1e-16),
                    Contains("too narrow"));
}

TEST_CASE("strata are estimated as Cochran's ratio, and summed by their areas") {
  // Three plots in A with 4, 6 and 8 trees on 0.1 ha each, and B with 2 trees on 0.1, 9 on 0.3 ha.
  std::vector<Tree> trees;
  const auto add = [&trees](const char* plot, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) trees.push_back({.dbh_cm = 20, .plot = plot});
  };
  add("1", 4);
  add("2", 6);
  add("3", 8);
  add("4", 2);
  add("5", 9);
  const Inventory stand = stand_of(trees);
  std::vector<SampledArea> areas = sampled_areas(stand, 1000.0);
  REQUIRE(areas.size() == 5);
  areas[4].area_m2 = 3000.0;
  const auto result =
      stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"A", 30.0}, {"B", 10.0}});
  REQUIRE(result.size() == 3);
  const StratumFigures& first = result[0];
  CHECK(first.name == "A");
  CHECK(first.plots == 3);
  CHECK(first.stems.per_ha == Approx(60.0).epsilon(1e-14));
  // Equal plots: the standard error of a mean of 40, 60 and 80 is 20 / sqrt(3).
  CHECK(first.stems.standard_error == Approx(20.0 / std::sqrt(3.0)).epsilon(1e-14));
  CHECK(first.stems.total == Approx(1800.0).epsilon(1e-14));
  CHECK(first.basal_area_m2.per_ha == Approx(60.0 * basal_area_m2(20)).epsilon(1e-14));
  // B: ratio 11 / 0.4; deviations 2 - 2.75 and 9 - 8.25.
  const StratumFigures& second = result[1];
  CHECK(second.stems.per_ha == Approx(27.5).epsilon(1e-14));
  const double error = std::sqrt(2.0 * 0.75 * 0.75 / 2.0) / 0.2;
  CHECK(second.stems.standard_error == Approx(error).epsilon(1e-13));
  const StratumFigures& all = result[2];
  CHECK(all.name.empty());
  CHECK(all.area_ha == 40.0);
  CHECK(all.stems.total == Approx(2075.0).epsilon(1e-14));
  CHECK(all.stems.total_standard_error ==
        Approx(std::hypot(30.0 * 20.0 / std::sqrt(3.0), 10.0 * error)).epsilon(1e-13));

  CHECK(stratum_figures(stand, areas, {}, {}).size() == 1);
  CHECK(stratum_figures(stand, areas, {}, {})[0].stems.per_ha == Approx(29.0 / 0.7).epsilon(1e-14));
  CHECK_THROWS_WITH(stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"A", 30.0}}),
                    Contains("no area for stratum 'B'"));
  CHECK_THROWS_WITH(stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"C", 30.0}}),
                    Contains("unknown stratum 'C'"));
  CHECK(std::isnan(stratum_figures(stand, {areas[0]}, {}, {})[0].stems.standard_error));
}
