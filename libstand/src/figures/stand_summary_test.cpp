// SPDX-License-Identifier: MIT
// Figures of plots, diameter classes and strata, against values worked out by hand.
#include "silvafit/stand/stand_summary.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/stand/stand_report.hpp"
#include "test_support/stand_test_support.hpp"

namespace data = silvafit::data;
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

TEST_CASE("dominant heights and diameters are those of ForestElementsR") {
  // The example of its h_100 and d_100 (version 2.1): an angle count with factor 4.
  const std::vector<double> dbh{12, 13, 25, 27, 28, 26, 26.1, 32, 35, 31, 42};
  double count = 0.0;
  for (const double d : dbh) count += 4.0 / basal_area_m2(d);
  // Each tree stands for 4 m2/ha.
  const double mean_cm = std::sqrt(4e4 / M_PI * 4.0 * static_cast<double>(dbh.size()) / count);
  std::vector<Tree> trees;
  for (const double d : dbh) {
    trees.push_back({.dbh_cm = d, .h_m = 0.9 * mean_cm * std::pow(d / mean_cm, 0.8)});
  }
  Inventory stand = stand_of(trees);
  for (const double d : dbh) stand.represented.push_back(4.0 / basal_area_m2(d));
  const StandFigures figures = stand_figures(stand, all_rows(stand), 1e4);
  // The twelve digits that R printed.
  CHECK(figures.dominant_lorey_height_m == Approx(29.894795852).epsilon(1e-11));
  CHECK(figures.dominant_dbh_cm == Approx(36.3485386548).epsilon(1e-11));
  CHECK(figures.dominant_height_m < figures.dominant_lorey_height_m);
}

TEST_CASE("diameter classes begin at their lower limit") {
  const Inventory stand =
      stand_of({{.dbh_cm = 7.9}, {.dbh_cm = 8.0}, {.dbh_cm = 11.9}, {.dbh_cm = 16.3}});
  const auto classes = diameter_distribution(stand, 1e4, 4.0);
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
  CHECK(diameter_distribution(small, 1e4, 0.1)[0].low_cm == Approx(0.3).epsilon(1e-14));
  CHECK_THROWS_WITH(diameter_distribution(stand, 1e4, 0.0), Contains("`class_width`"));
  CHECK_THROWS_WITH(diameter_distribution(stand, 1e4, 1e-6), Contains("too narrow"));
  // Equal diameters need one class, but not one whose number is beyond the whole numbers.
  const Inventory equal = stand_of({{.dbh_cm = 20.0}, {.dbh_cm = 20.0}});
  CHECK_THROWS_WITH(diameter_distribution(equal, 1e4, 1e-16), Contains("too narrow"));
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

namespace {

/// Seven plots of 0.05 ha in two strata of 1 and 2.5 ha, 20 and 50 plots, with a value of each
/// tree.
struct SurveyExample {
  Inventory stand{};
  StandReportOptions options{};

  SurveyExample() {
    const std::vector<const char*> plots{
        "1", "1", "1", "2", "2", "3", "3", "3", "3", "4", "5", "5", "6", "7", "7", "7"};
    const std::string species = "ffofooffofoofoof";
    std::vector<Tree> trees;
    data::TextColumn strata;
    for (std::size_t i = 0; i < plots.size(); ++i) {
      trees.push_back({.species = species[i] == 'f' ? "f" : "o", .plot = plots[i]});
      strata.append(*plots[i] < '5' ? "A" : "B");
    }
    stand = stand_of(trees);
    stand.x.clear();
    stand.y.clear();
    stand.other = data::Table(stand.size());
    stand.other.set("stratum", std::move(strata));
    stand.quantities = {{.name = "v", .values = {1, 2, 4, 3, 5, 2, 2, 6, 1, 7, 4, 3, 9, 2, 5, 8}}};
    options.plot_area_m2 = 500.0;
    options.stratum = "stratum";
    options.stratum_areas_ha = {{"A", 1.0}, {"B", 2.5}};
    options.by = {"species"};
  }
};

}  // namespace

TEST_CASE("stratified estimates of all trees and of species are those of the R package survey") {
  // svydesign(~1, strata = ~stratum, weights, fpc = ~N), svytotal and svyratio of survey 4.1-1,
  // printed with 14 digits.
  SurveyExample example;
  const auto near = [](double value) { return Approx(value).epsilon(1e-11); };
  for (const bool is_finite : {false, true}) {
    example.options.strata.is_finite = is_finite;
    const StandReport report = stand_report(example.stand, example.options);
    const StratumFigures& all = report.strata.back();
    CHECK(all.stems.total == near(150.0));
    CHECK(all.stems.total_standard_error == near(is_finite ? 30.276503540975 : 31.622776601684));
    CHECK(all.quantities[0].total == near(681.666666666667));
    CHECK(all.quantities[0].total_standard_error ==
          near(is_finite ? 117.747375531026 : 121.666666666667));
    CHECK(all.quantities_of_tree[0].value == near(4.54444444444444));
    CHECK(all.quantities_of_tree[0].standard_error ==
          near(is_finite ? 0.67010764922175 : 0.70130781220679));
    REQUIRE(report.domains.size() == 2);
    CHECK(report.domains[0].labels == std::vector<std::string>{"f"});
    const StratumFigures& first = report.domains[0].figures;
    CHECK(first.stems.total == near(63.3333333333333));
    CHECK(first.stems.total_standard_error == near(is_finite ? 16.964014199999 : 17.638342073764));
    CHECK(first.quantities[0].total_standard_error ==
          near(is_finite ? 140.051577800625 : 144.808302401639));
    CHECK(first.quantities_of_tree[0].standard_error ==
          near(is_finite ? 0.8724175426306 : 0.93505077318562));
  }
}

TEST_CASE("post-stratified variances are those of Bechtold and Patterson") {
  // Their formula in R, with weights 2/7 and 5/7 and the variances of the plots' sums.
  SurveyExample example;
  example.options.strata.are_posterior = true;
  const StandReport report = stand_report(example.stand, example.options);
  const StratumFigures& all = report.strata.back();
  CHECK(all.quantities[0].total_standard_error == Approx(100.67037205416).epsilon(1e-11));
  CHECK(report.domains[0].figures.stems.total_standard_error ==
        Approx(16.329931618555).epsilon(1e-11));
  // Two estimation units: each stratum is then the only one of its unit, and is not posterior.
  example.options.strata.unit_of_stratum = {{"A", "1"}, {"B", "2"}};
  CHECK(stand_report(example.stand, example.options).strata.back().stems.total_standard_error ==
        Approx(31.622776601684).epsilon(1e-11));
  example.options.stratum_areas_ha.clear();
  CHECK_THROWS_WITH(stand_report(example.stand, example.options), Contains("`post_stratified`"));
  example.options.stratum_areas_ha = {{"A", 0.1}, {"B", 2.5}};
  example.options.strata = {.is_finite = true};
  CHECK_THROWS_WITH(stand_report(example.stand, example.options),
                    Contains("'A' cover 0.2 ha, more than its area of 0.1 ha"));
}

TEST_CASE("kinds of trees add up to all trees") {
  SurveyExample example;
  for (std::size_t i = 0; i < example.stand.size(); ++i) {
    example.stand.dbh_cm[i] = 8.0 + static_cast<double>(i);
  }
  example.options.by = {"species", "dbh"};
  const StandReport report = stand_report(example.stand, example.options);
  CHECK(report.domains.front().labels == std::vector<std::string>{"f", "8-12"});
  double total = 0.0;
  std::size_t trees = 0;
  for (const DomainFigures& domain : report.domains) {
    total += domain.figures.quantities[0].total;
    trees += domain.figures.trees;
  }
  CHECK(trees == example.stand.size());
  CHECK(total == Approx(report.strata.back().quantities[0].total).epsilon(1e-13));
  example.options.by = {"layer"};
  CHECK_THROWS_WITH(stand_report(example.stand, example.options), Contains("`by`"));
}
