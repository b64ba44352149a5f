// SPDX-License-Identifier: MIT
#include "silvafit/stand/thinning.hpp"

#include <catch2/catch.hpp>

#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

/// Two plots of 100 m2 with trees of 10, 20, 30 and 40 cm, and of 30 cm alone.
Inventory thinning_stand() {
  Inventory stand = stand_of({{.dbh_cm = 20},
                              {.dbh_cm = 10},
                              {.dbh_cm = 40},
                              {.dbh_cm = 30},
                              {.dbh_cm = 30, .plot = "2"}});
  stand.x.clear();
  stand.y.clear();
  return stand;
}

StandReport thinning_report(const Inventory& stand) {
  StandReportOptions options;
  options.plot_area_m2 = 100.0;
  options.trust_units = true;
  return stand_report(stand, options);
}

}  // namespace

TEST_CASE("a thinning from below leaves the target basal area or a little more") {
  const Inventory stand = thinning_stand();
  const StandReport report = thinning_report(stand);
  // Plot 1 has pi/4 (0.01 + 0.04 + 0.09 + 0.16) m2; without the two thinnest 0.25 pi/4 remain,
  // 19.63 m2/ha, and without the third tree 12.57.
  const Thinning below = thin(stand, report, parse_thinning("below=15"));
  CHECK(below.is_removed == std::vector<char>{1, 1, 0, 0, 0});
  REQUIRE(below.plots.size() == 2);
  CHECK(below.plots[0].before.trees == 4);
  CHECK(below.plots[0].removed.basal_area_m2_per_ha == Approx(M_PI / 4.0 * 5.0).epsilon(1e-13));
  CHECK(below.plots[0].after.basal_area_m2_per_ha == Approx(M_PI / 4.0 * 25.0).epsilon(1e-13));
  // Plot 2 has 7.07 m2/ha, less than the target.
  CHECK(below.plots[1].removed.trees == 0);
  CHECK(below.all.after.trees == 3);
  CHECK(below.all.before.area_ha == 0.02);
  const Thinning above = thin(stand, report, parse_thinning("above=10"));
  CHECK(above.is_removed == std::vector<char>{0, 0, 1, 0, 0});
  // A target of 0 removes all.
  CHECK(thin(stand, report, parse_thinning("below=0")).all.after.trees == 0);
}

TEST_CASE("marked trees are removed") {
  Inventory stand = thinning_stand();
  stand.other = silvafit::data::Table(stand.size());
  stand.other.set("cut", std::vector<double>{0, 1, 0, NAN, 2});
  const StandReport report = thinning_report(stand);
  CHECK(thin(stand, report, parse_thinning("marked=cut")).is_removed ==
        std::vector<char>{0, 1, 0, 0, 1});
  CHECK_THROWS_WITH(thin(stand, report, parse_thinning("marked=tree")), Contains("`thinning`"));
  CHECK_THROWS_WITH(parse_thinning("below"), Contains("is not a rule"));
  CHECK_THROWS_WITH(parse_thinning("below=-1"), Contains("is not a rule"));
  CHECK_THROWS_WITH(parse_thinning("marked="), Contains("is not a rule"));
}
