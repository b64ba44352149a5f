// SPDX-License-Identifier: MIT
// Expansion factors, estimates and complete neighborhoods of sampled plots, against published
// factors and values worked out by hand.
#include "silvafit/stand/sampling_design.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "test_support/inventory_test_support.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit;
using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

data::TableSource table_text(const std::string& text) {
  return std::make_shared<const data::TableText>(
      data::TableText{.name = "plots.csv", .text = text, .separator = ','});
}

PlotTable plots_of(const std::string& text) { return read_plot_table(table_text(text)); }

double stems_per_ha(const DesignedSample& sample, std::size_t tree, std::size_t area = 0) {
  return sample.represented[tree] / (sample.areas[area].area_m2 / 1e4);
}

Inventory without_positions(const std::vector<Tree>& trees) {
  Inventory inventory = stand_of(trees);
  inventory.x.clear();
  inventory.y.clear();
  return inventory;
}

bool says(const std::vector<std::string>& notes, const std::string& text) {
  return std::ranges::any_of(
      notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

}  // namespace

TEST_CASE("Strata by a column of the trees are refused beside a table of plots with others") {
  const Inventory trees =
      read_inventory_text("plot,tree,dbh,zone\n1,1,20,A\n2,1,30,B\n", {.keep = {"zone"}}).inventory;
  StandReportOptions options{.stratum = "zone"};
  options.design.plots = plots_of("plot,area,stratum,stratum_area\n1,1000,A,30\n2,1000,B,60\n");
  CHECK_THROWS_WITH(stand_report(trees, options), Contains("omit `stratum`"));
}

TEST_CASE("FIA's subplots and microplots have the published factors TPA_UNADJ") {
  // Bechtold and Patterson 2005: four subplots of 24.0 ft and microplots of 6.8 ft; FIADB User
  // Guide, TREE.TPA_UNADJ: 6.018046 and 74.965282 trees per acre.
  constexpr double kMetersPerFoot = 0.3048;
  constexpr double kHectaresPerAcre = 0.40468564224;
  const SamplingDesign design{
      .circles = {{2.54, 6.8 * kMetersPerFoot}, {12.7, 24.0 * kMetersPerFoot}}, .subplots = 4};
  const Inventory stand = without_positions({{.dbh_cm = 2.6}, {.dbh_cm = 12.7}, {.dbh_cm = 60.0}});
  const DesignedSample sample = sample_of(stand, design);
  REQUIRE(sample.areas.size() == 1);
  // The digits of the publication.
  CHECK(stems_per_ha(sample, 0) * kHectaresPerAcre == Approx(74.965282).epsilon(1e-7));
  CHECK(stems_per_ha(sample, 1) * kHectaresPerAcre == Approx(6.018046).epsilon(1e-7));
  CHECK(stems_per_ha(sample, 2) == stems_per_ha(sample, 1));
  CHECK(sample.areas[0].area_m2 == Approx(4 * M_PI * std::pow(24 * kMetersPerFoot, 2)));
}

TEST_CASE("Each tree of an angle count has the basal area factor") {
  // Kershaw and others 2017: basal area = number of trees times the factor, whatever their dbh.
  const SamplingDesign design{.basal_area_factor = 4.0};
  const Inventory stand = without_positions(
      {{.dbh_cm = 10}, {.dbh_cm = 20}, {.dbh_cm = 40}, {.dbh_cm = 30, .plot = "2"}});
  StandReportOptions options{.design = design};
  const StandReport report = stand_report(stand, options);
  REQUIRE(report.areas.size() == 2);
  CHECK(report.areas[0].figures.basal_area_m2_per_ha == Approx(12.0).epsilon(1e-13));
  // 4 / (pi/4 d^2): the reciprocal squares of the diameters.
  const double stems = 4.0 / (M_PI / 4.0) * (1 / 0.01 + 1 / 0.04 + 1 / 0.16);
  CHECK(report.areas[0].figures.stems_per_ha == Approx(stems).epsilon(1e-13));
  // Of an angle count the quadratic mean is the harmonic mean of the squares.
  CHECK(report.areas[0].figures.quadratic_mean_dbh_cm ==
        Approx(100.0 * std::sqrt(3.0 / (1 / 0.01 + 1 / 0.04 + 1 / 0.16))).epsilon(1e-13));
  CHECK(std::isnan(report.areas[0].figures.area_ha));
  // Points are equal: the mean of 12 and 4, with standard error sqrt(((12-8)^2+(4-8)^2)/(2*1)).
  CHECK(report.strata.back().basal_area_m2.per_ha == Approx(8.0).epsilon(1e-13));
  CHECK(report.strata.back().basal_area_m2.standard_error == Approx(4.0).epsilon(1e-13));
}

TEST_CASE("Concentric circles weight trees by the area of their circle") {
  const SamplingDesign design{.circles = {{7, 4}, {15, 8}, {30, 12}}};
  const Inventory stand = stand_of({{.x = 1, .dbh_cm = 7, .h_m = 8},
                                    {.y = 5, .dbh_cm = 15, .h_m = 14},
                                    {.x = -11, .dbh_cm = 30, .h_m = 22},
                                    {.x = 2, .dbh_cm = 6.9, .h_m = 7},
                                    {.x = 5, .dbh_cm = 10, .h_m = 9},
                                    {.x = 0, .y = 3, .dbh_cm = 40, .h_m = 25}});
  const DesignedSample sample = sample_of(stand, design);
  REQUIRE(sample.areas.size() == 1);
  // Not the fourth, which is too thin, nor the fifth, which is 5 m from the center and too thin
  // for the circle of 8 m.
  CHECK(sample.areas[0].trees == std::vector<std::size_t>{0, 1, 2, 5});
  CHECK(says(sample.notes, "1 tree is not counted: below dbh 7 cm"));
  CHECK(says(sample.notes, "dbh 10 cm is counted up to 4 m (plot 1, tree 5)"));
  CHECK(stems_per_ha(sample, 0) == Approx(1e4 / (M_PI * 16)).epsilon(1e-13));
  CHECK(stems_per_ha(sample, 1) == Approx(1e4 / (M_PI * 64)).epsilon(1e-13));
  CHECK(stems_per_ha(sample, 5) == Approx(1e4 / (M_PI * 144)).epsilon(1e-13));
  StandReportOptions options{.design = design};
  options.units.edge = EdgeCorrection::kNone;
  options.units.neighbors = 1;
  const StandReport report = stand_report(stand, options);
  const StandFigures& figures = report.areas[0].figures;
  // Weights 9, 9/4, 1, 1 relative to the largest circle.
  const double weights = 9 + 2.25 + 2;
  CHECK(figures.stems_per_ha == Approx(weights * 1e4 / (M_PI * 144)).epsilon(1e-13));
  CHECK(figures.mean_height_m == Approx((9 * 8 + 2.25 * 14 + 22 + 25) / weights).epsilon(1e-13));
  CHECK(figures.mean_dbh_cm == Approx((9 * 7 + 2.25 * 15 + 30 + 40) / weights).epsilon(1e-13));
  // 100 trees per ha are 4.52 of this plot: two trees, 2.25 of the third and no more.
  const double wanted = 100 * M_PI * 144 / 1e4;
  CHECK(figures.dominant_height_m ==
        Approx((25 + 22 + 2.25 * 14 + (wanted - 4.25) * 8) / wanted).epsilon(1e-13));
  // Core trees are those within 4 m, where all trees from 7 cm were measured.
  REQUIRE(report.units);
  CHECK(report.units->core == std::vector<char>{1, 0, 0, 1, 0, 1});
}

TEST_CASE("A buffer is within the circle of the smallest counted dbh") {
  const SamplingDesign design{.circles = {{7, 10}, {30, 15}}};
  const Inventory stand = stand_of({{.x = 0, .dbh_cm = 8},
                                    {.x = 4.9, .dbh_cm = 8},
                                    {.x = 5.1, .dbh_cm = 8},
                                    {.x = 12, .dbh_cm = 35},
                                    {.x = -3, .dbh_cm = 40}});
  StructuralUnitOptions options{.neighbors = 1, .buffer_m = 5.0};
  const DesignedSample sample = sample_of(stand, design);
  CHECK(structural_units_of_sample(stand, sample, options).core ==
        std::vector<char>{1, 1, 0, 0, 1});
  // Hegyi's competitors within 8 m are complete only within 2 m of the center.
  options.further = {FurtherIndex::kHegyi};
  options.competition_radius_m = 8.0;
  CHECK(structural_units_of_sample(stand, sample, options).core ==
        std::vector<char>{1, 0, 0, 0, 0});
}

TEST_CASE("BAL of concentric circles counts trees as often as they stand for others") {
  const SamplingDesign design{.circles = {{0, 5}, {30, 10}}};
  const Inventory stand =
      stand_of({{.x = 1, .dbh_cm = 10}, {.x = 2, .dbh_cm = 20}, {.x = 8, .dbh_cm = 40}});
  StructuralUnitOptions options{.neighbors = 1, .edge = EdgeCorrection::kNone};
  options.further = {FurtherIndex::kBasalAreaLarger};
  const StructuralUnits units =
      structural_units_of_sample(stand, sample_of(stand, design), options);
  const double of_20 = basal_area_m2(20) * 1e4 / (M_PI * 25);
  const double of_40 = basal_area_m2(40) * 1e4 / (M_PI * 100);
  CHECK(units.further[0].values[0] == Approx(of_20 + of_40).epsilon(1e-13));
  CHECK(units.further[0].values[1] == Approx(of_40).epsilon(1e-13));
  CHECK(units.further[0].values[2] == 0.0);
}

TEST_CASE("Distances along the slope make smaller areas") {
  const Inventory stand = without_positions({{.dbh_cm = 20}});
  SamplingDesign design{.plots = plots_of("plot,area,slope\n1,500,60\n"), .corrects_slope = true};
  // cos 60 degrees = 1/2
  const DesignedSample degrees = sample_of(stand, design);
  CHECK(degrees.areas[0].area_m2 == Approx(250.0).epsilon(1e-13));
  CHECK(says(degrees.notes, "read in degrees; if it is in percent"));
  design.plots = plots_of("plot,area,Slope (%)\n1,500,100\n");
  const DesignedSample percent = sample_of(stand, design);
  CHECK(percent.areas[0].area_m2 == Approx(500 / std::sqrt(2)).epsilon(1e-13));
  CHECK_FALSE(says(percent.notes, "in degrees"));
  design.corrects_slope = false;
  const DesignedSample level = sample_of(stand, design);
  CHECK(level.areas[0].area_m2 == 500.0);
  CHECK(says(level.notes, "`slope_correction`"));
  // An angle count's basal area is multiplied by the secant.
  SamplingDesign angle{
      .plots = plots_of("plot,slope\n1,60\n"), .basal_area_factor = 2.0, .corrects_slope = true};
  const DesignedSample sample = sample_of(stand, angle);
  CHECK(stems_per_ha(sample, 0) * basal_area_m2(20) == Approx(4.0).epsilon(1e-13));
}

TEST_CASE("A plot partly outside of the population has a smaller area") {
  // Half of plot 2 is outside: its 3 trees stand on half the area.
  const Inventory stand = without_positions({{.dbh_cm = 20},
                                             {.dbh_cm = 20},
                                             {.dbh_cm = 20},
                                             {.dbh_cm = 20},
                                             {.dbh_cm = 20, .plot = "2"},
                                             {.dbh_cm = 20, .plot = "2"},
                                             {.dbh_cm = 20, .plot = "2"}});
  const SamplingDesign design{.plots = plots_of("plot,share\n1,1\n2,0.5\n"), .circles = {{7, 10}}};
  const StandReport report = stand_report(stand, {.design = design});
  const double area_ha = M_PI * 100 / 1e4;
  CHECK(report.areas[1].figures.stems_per_ha == Approx(6 / area_ha).epsilon(1e-13));
  // Ratio of sums: 7 trees on 1.5 plots; residuals 4 - 14/3 and 3 - 7/3; mean size 3/4.
  CHECK(report.strata[0].stems.per_ha == Approx(7 / 1.5 / area_ha).epsilon(1e-13));
  const double squares = 4.0 / 9.0 + 4.0 / 9.0;
  CHECK(report.strata[0].stems.standard_error ==
        Approx(std::sqrt(squares / 2.0) / 0.75 / area_ha).epsilon(1e-13));
}

TEST_CASE("Expansion factors of a column are those of FIA's trees") {
  Inventory stand = without_positions(
      {{.dbh_cm = 20}, {.dbh_cm = 10}, {.dbh_cm = 30, .plot = "2"}, {.dbh_cm = 31, .plot = "2"}});
  stand.other = data::Table(4);
  stand.other.set("TPH", std::vector<double>{14.87, 185.2, 14.87, 14.87});
  const StandReport report = stand_report(stand, {.design = {.expansion = "TPH"}});
  CHECK(report.areas[0].figures.stems_per_ha == Approx(14.87 + 185.2).epsilon(1e-13));
  CHECK(report.strata.back().stems.per_ha == Approx((14.87 * 3 + 185.2) / 2).epsilon(1e-13));
  stand.other.set("TPH", std::vector<double>{14.87, NAN, 14.87, 14.87});
  CHECK_THROWS_WITH(stand_report(stand, {.design = {.expansion = "TPH"}}),
                    Contains("TPH: the expansion factor is missing") && Contains("tree 2"));
  CHECK_THROWS_WITH(stand_report(stand, {.design = {.expansion = "tph"}}), Contains("'tph'"));
}

TEST_CASE("Plots without trees are counted, and plots that do not match are listed") {
  const Inventory stand =
      without_positions({{.dbh_cm = 20, .plot = "1"}, {.dbh_cm = 30, .plot = "7a"}});
  const PlotTable plots = plots_of("plot,area\n1,400\n2,400\n7,400\n");
  const DesignedSample sample = sample_of(stand, {.plots = plots});
  REQUIRE(sample.areas.size() == 3);
  CHECK(sample.areas[0].name == "1");
  CHECK(sample.areas[1].name == "2");
  CHECK(sample.areas[1].trees.empty());
  CHECK(says(sample.notes, "1 plot is not in the table of plots and not counted"));
  CHECK(says(sample.notes, "not counted, because the area is unknown: 7a"));
  CHECK(says(sample.notes, "2 plots of the table have no tree and are counted as empty: 2, 7"));
  const Inventory zeros =
      without_positions({{.dbh_cm = 20, .plot = "1"}, {.dbh_cm = 30, .plot = "07"}});
  CHECK_THROWS_WITH(sample_of(zeros, {.plots = plots}), Contains("'07' and '7'"));
}

TEST_CASE("Plots all of whose trees are dead or cut are empty plots") {
  const CheckedInventory read = read_inventory_text(
      "plot,tree,dbh,status\n1,1,20,alive\n1,2,25,alive\n2,1,20,dead\n2,2,25,cut\n3,1,30,alive\n"
      "3,2,25,dead\n4,1,,alive\n4,2,20,dead\n");
  // Of plot 4 a living tree without dbh is unknown.
  CHECK(read.inventory.plots_without_trees == std::vector<std::string>{"2"});
  StandReportOptions fixed;
  fixed.plot_area_m2 = 500.0;
  StandReportOptions circles;
  circles.design.circles = {{.from_dbh_cm = 7.0, .radius_m = std::sqrt(500.0 / M_PI)}};
  for (const StandReportOptions& options : {fixed, circles}) {
    const StandReport report = stand_report(read.inventory, options);
    REQUIRE(report.areas.size() == 3);
    // 40, 0 and 20 trees per ha: mean 20, standard error 20/sqrt(3).
    CHECK(report.strata.back().stems.per_ha == Approx(20.0).epsilon(1e-12));
    CHECK(report.strata.back().stems.standard_error ==
          Approx(20.0 / std::sqrt(3.0)).epsilon(1e-12));
    CHECK(says(report.notes, "1 plot has no living tree and counts as empty: 2"));
  }
}

TEST_CASE("The table of plots has the empty plots of areas that hold for every plot") {
  const Inventory stand = stand_of({{.dbh_cm = 20, .plot = "1"}, {.dbh_cm = 30, .plot = "2"}});
  StandReportOptions fixed{.design = {.plots = plots_of("plot,stratum\n1,A\n2,A\n3,A\n4,A\n")}};
  fixed.plot_area_m2 = 500.0;
  StandReportOptions circle = fixed;
  circle.plot_area_m2.reset();
  circle.units.windows = {{kEveryPlot, Window::circle({0, 0}, std::sqrt(500.0 / M_PI))}};
  circle.without_units = true;
  for (StandReportOptions options : {fixed, circle}) {
    const StandReport report = stand_report(stand, options);
    // 20, 20, 0 and 0 trees per ha: mean 10, standard error sqrt(400/3)/2.
    REQUIRE(report.areas.size() == 4);
    CHECK(report.strata.back().stems.per_ha == Approx(10.0).epsilon(1e-12));
    CHECK(report.strata.back().stems.standard_error ==
          Approx(std::sqrt(400.0 / 3.0) / 2.0).epsilon(1e-12));
    CHECK(says(report.notes, "2 plots of the table have no tree and are counted as empty: 3, 4"));
    options.design.plots = plots_of("plot,area\n1,510\n2,200\n");
    CHECK_THROWS_WITH(stand_report(stand, options),
                      Contains(":3") && Contains("the plot has 200 m2 in the table of plots"));
    options.design.plots = plots_of("plot,share\n1,1\n2,0.5\n");
    CHECK_THROWS_WITH(stand_report(stand, options), Contains("share of the table of plots"));
  }
}

TEST_CASE("Plots all of whose trees lack the factor are unknown, not empty") {
  Inventory stand = without_positions({{.dbh_cm = 20, .plot = "1", .h_m = 15},
                                       {.dbh_cm = 30, .plot = "1", .h_m = 25},
                                       {.dbh_cm = 30, .plot = "2", .h_m = 20}});
  stand.expansion = "TPH";
  stand.other.set("TPH", std::vector<double>{100.0, NAN, NAN});
  const StandReport report = stand_report(stand, {.design = {.expansion = "TPH"}});
  REQUIRE(report.areas.size() == 1);
  CHECK(report.all.stems_per_ha == Approx(100.0).epsilon(1e-14));
  CHECK(report.all.trees == 1);
  CHECK(report.all.mean_height_m == Approx(15.0).epsilon(1e-14));
  CHECK(says(report.notes, "1 plot is unknown and not counted, because no tree has a factor: 2"));
  stand.other.set("TPH", std::vector<double>(3, NAN));
  CHECK_THROWS_WITH(stand_report(stand, {.design = {.expansion = "TPH"}}),
                    Contains("no tree has an expansion factor"));
  // Areas replace the factors.
  CHECK(says(stand_report(stand, {.plot_area_m2 = 500.0}).notes, "which are not used"));
}

TEST_CASE("Factors per acre are converted by the name of their column") {
  Inventory stand = without_positions({{.dbh_cm = 20, .plot = "1"}, {.dbh_cm = 30, .plot = "1"}});
  stand.other.set("TPA_UNADJ", std::vector<double>{6.018046, 6.018046});
  const StandReport report = stand_report(stand, {.design = {.expansion = "TPA_UNADJ"}});
  CHECK(report.areas[0].figures.stems_per_ha ==
        Approx(2 * 6.018046 / 0.40468564224).epsilon(1e-13));
  // In a table of plots, too: its factor is the area of the plot.
  const StandReport of_plots =
      stand_report(stand, {.design = {.plots = plots_of("plot,TPA\n1,6.018046\n")}});
  CHECK(of_plots.areas[0].figures.stems_per_ha ==
        Approx(2 * 6.018046 / 0.40468564224).epsilon(1e-13));
}

TEST_CASE("Strata of the table of plots are combined by their areas or weights") {
  std::vector<Tree> trees;
  const auto add = [&trees](const char* plot, std::size_t count, double h_m) {
    for (std::size_t i = 0; i < count; ++i) {
      trees.push_back({.dbh_cm = 20, .plot = plot, .h_m = h_m});
    }
  };
  add("1", 4, 10);
  add("2", 8, 13);
  add("3", 1, 20);
  const Inventory stand = without_positions(trees);
  const SamplingDesign design{.plots = plots_of("plot,area,stratum,stratum_area\n1,1000,A,30\n"
                                                "2,1000,A,30\n3,1000,B,10\n4,1000,B,10\n")};
  const StandReport report = stand_report(stand, {.design = design});
  REQUIRE(report.strata.size() == 3);
  // A: 40 and 80 per ha, mean 60, se 20; B: 10 and 0, mean 5, se 5.
  CHECK(report.strata[0].stems.per_ha == Approx(60.0).epsilon(1e-13));
  CHECK(report.strata[0].stems.standard_error == Approx(20.0).epsilon(1e-13));
  CHECK(report.strata[1].stems.standard_error == Approx(5.0).epsilon(1e-13));
  const StratumFigures& all = report.strata[2];
  CHECK(all.stems.total == Approx(60 * 30 + 5 * 10).epsilon(1e-13));
  CHECK(all.stems.total_standard_error == Approx(std::hypot(600, 50)).epsilon(1e-13));
  CHECK(all.stems.per_ha == Approx(1850.0 / 40).epsilon(1e-13));
  // Mean height: totals of heights 30 (40*10 + 80*13)/2 + 10 (10*20)/2 = 22600 over 1850 trees.
  const double mean = 22600.0 / 1850.0;
  CHECK(all.mean_height_m.value == Approx(mean).epsilon(1e-13));
  // Residuals per ha: A 40 (10 - R), 80 (13 - R); B 10 (20 - R), 0.
  const double a = (40 * (10 - mean) - 80 * (13 - mean)) / 2;
  const double b = 10 * (20 - mean) / 2;
  CHECK(all.mean_height_m.standard_error ==
        Approx(std::hypot(30 * a, 10 * b) / 1850).epsilon(1e-12));
  // The same diameters everywhere: a mean without error.
  CHECK(all.quadratic_mean_dbh_cm.value == Approx(20.0).epsilon(1e-13));
  CHECK(all.quadratic_mean_dbh_cm.standard_error == Approx(0.0).margin(1e-13));
  CHECK(report.areas[0].stratum == "A");

  const SamplingDesign weighted{.plots = plots_of("plot,area,stratum,stratum_weight\n1,1000,A,3\n"
                                                  "2,1000,A,3\n3,1000,B,1\n4,1000,B,1\n")};
  const StratumFigures by_weight = stand_report(stand, {.design = weighted}).strata[2];
  CHECK(by_weight.stems.per_ha == Approx(1850.0 / 40).epsilon(1e-13));
  CHECK(by_weight.stems.standard_error == Approx(std::hypot(600, 50) / 40).epsilon(1e-13));
  CHECK(std::isnan(by_weight.stems.total));
}

TEST_CASE("Positions are from the center of a plot or from a map") {
  const PlotTable plots = plots_of("plot,radius,x,y\n1,5,1000,2000\n2,5,3000,2000\n");
  const Inventory on_map = stand_of({{.x = 1004, .y = 2000}, {.x = 3000, .y = 1996, .plot = "2"}});
  const DesignedSample map = sample_of(on_map, {.plots = plots});
  REQUIRE(map.complete_circles.size() == 2);
  CHECK(map.complete_circles[1].window.low().x == 2995.0);
  CHECK(says(map.notes, "centers of plots are x and y"));
  const Inventory relative = stand_of({{.x = 4, .y = 0}, {.x = 0, .y = -4, .plot = "2"}});
  CHECK(sample_of(relative, {.plots = plots}).complete_circles[1].window.low().x == -5.0);
  // A map without centers: neither circles nor trees outside of them are known.
  const DesignedSample unknown = sample_of(on_map, {.plots = plots_of("plot,radius\n1,5\n2,5\n")});
  CHECK(unknown.complete_circles.empty());
  CHECK(unknown.areas[0].trees.size() == 1);
  CHECK(says(unknown.notes, "give the centers of plots"));
}

TEST_CASE("Trees that cannot have been counted in their circles need the centers") {
  // Four trees on a square of 20 m around 0, 0, of which one is within 5 m.
  const Inventory map =
      stand_of({{.x = 1, .y = 1}, {.x = -10, .y = 0}, {.x = 10, .y = 10}, {.x = 0, .y = -10}});
  const auto with_center = [](const std::string& x) {
    return SamplingDesign{.plots = plots_of("plot,radius,x,y\n1,5," + x + ",0\n")};
  };
  CHECK(sample_of(map, with_center("0")).areas[0].trees == std::vector<std::size_t>{0});
  CHECK(sample_of(map, with_center("-10")).areas[0].trees == std::vector<std::size_t>{1});
  CHECK_THROWS_WITH(sample_of(map, with_center("500")),
                    Contains("only 1 of 4 trees with positions are within their plots around the "
                             "origin or the centers"));
  const SamplingDesign without{.plots = plots_of("plot,radius\n1,5\n")};
  CHECK_THROWS_WITH(sample_of(map, without), Contains("farther apart than these are wide"));
  // Twice the radius apart, trees fit into a circle somewhere.
  const Inventory list =
      stand_of({{.x = 100, .y = 100}, {.x = 109, .y = 100}, {.x = 104, .y = 104}});
  CHECK(sample_of(list, without).areas[0].trees.size() == 3);
}

TEST_CASE("Small trees that were mapped in the largest circle are outside of their own") {
  // Trees of 10 cm are counted up to 4 m, of 40 cm up to 12 m; all within 12 m were mapped.
  const Inventory all = stand_of({{.x = 3, .y = 0, .dbh_cm = 10},
                                  {.x = 0, .y = 9, .dbh_cm = 10},
                                  {.x = -11, .y = 0, .dbh_cm = 10},
                                  {.x = -8, .y = 8, .dbh_cm = 40}});
  const SamplingDesign design{.circles = {{7, 4}, {30, 12}}};
  CHECK(sample_of(all, design).areas[0].trees == std::vector<std::size_t>{0, 3});
}

TEST_CASE("An angle count on a map of all trees counts those within their limiting distance") {
  // 400 trees of 20 cm on a grid of 1 m: 20 / (2 sqrt(4)) = 5 m around the center of the map.
  std::vector<Tree> trees;
  std::size_t within = 0;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      trees.push_back({.x = 100.0 + i, .y = 200.0 + j, .dbh_cm = 20.0});
      if (std::hypot(i - 9.5, j - 9.5) <= 5.0) ++within;
    }
  }
  const DesignedSample sample = sample_of(
      stand_of(trees), {.plots = plots_of("plot,x,y\n1,109.5,209.5\n"), .basal_area_factor = 4.0});
  CHECK(sample.areas[0].trees.size() == within);
}

TEST_CASE("Neighbors are searched within subplots") {
  // Two subplots at the same coordinates: the nearest neighbor is that of the own subplot.
  Inventory stand = stand_of({{.x = 0}, {.x = 2}, {.x = 0.5}, {.x = 3}});
  stand.other = data::Table(4);
  stand.other.set("subp", std::vector<double>{1, 1, 2, 2});
  const SamplingDesign design{.circles = {{5, 7}}, .subplots = 2, .subplot = "subp"};
  const StructuralUnits units = structural_units_of_sample(
      stand, sample_of(stand, design), {.neighbors = 1, .edge = EdgeCorrection::kNone});
  CHECK(units.nearest == std::vector<std::uint32_t>{1, 0, 3, 2});
}

TEST_CASE("A table of plots is checked") {
  CHECK_THROWS_WITH(plots_of("name,area\n1,400\n"), Contains("`plots_columns=plot=COLUMN`"));
  CHECK_THROWS_WITH(plots_of("plot,area\n1,0\n2,x\n"),
                    Contains("plots.csv:2: area: 0 must be above 0 (plot 1)") &&
                        Contains("plots.csv:3: area: 'x' is not a number (plot 2)"));
  // FIA's adjusted proportions exceed 1; percentages are errors.
  CHECK_THROWS_WITH(plots_of("plot,share\n1,50\n"), Contains("at most 2"));
  CHECK_THROWS_WITH(plots_of("plot,slope\n1,90\n"), Contains("below 90"));
  CHECK_THROWS_WITH(plots_of("plot,area\n1,400\n1,500\n"), Contains("already on line 2"));
  CHECK_THROWS_WITH(read_plot_table(table_text("plot,area\n1,4\n"), {{"size", "area"}}),
                    Contains("'size' is not a column of plots"));
  const PlotTable usual = plots_of("Plot ID,Area (ha),Stratum ID,Year\n7,0.04,A,2019\n");
  CHECK(usual.plots[0].area_m2 == Approx(400.0).epsilon(1e-14));
  CHECK(usual.plots[0].stratum == "A");
  CHECK(usual.plots[0].time == "2019");
  // Two dates of a plot are two measurements.
  CHECK(plots_of("plot,year,area\n1,2019,400\n1,2024,400\n").plots.size() == 2);
  CHECK_THROWS_WITH(sample_of(without_positions({{.dbh_cm = 20}}),
                              {.plots = plots_of("plot,year,area\n1,2019,400\n1,2024,400\n")}),
                    Contains("listed twice"));
}

TEST_CASE("Columns of a table of plots that are named replace others with the same meaning") {
  const auto area_of = [](const std::string& text, const std::vector<ColumnMapping>& named) {
    const SamplingDesign design{.plots = read_plot_table(table_text(text), named),
                                .corrects_slope = true};
    return sample_of(without_positions({{.dbh_cm = 20}}), design).areas[0].area_m2;
  };
  const std::string both = "plot,area,r,slope\n1,500,10,60\n";
  CHECK(area_of(both, {{"radius", "r"}}) == Approx(M_PI * 100.0 / 2.0).epsilon(1e-13));
  CHECK(area_of(both, {{"expansion", "r*0 + 25"}}) == Approx(400.0 / 2.0).epsilon(1e-13));
  // 60 % are atan(0.6).
  CHECK(area_of(both, {{"area", "area"}, {"slope_percent", "slope"}}) ==
        Approx(500.0 / std::sqrt(1.36)).epsilon(1e-13));
  const PlotTable named = read_plot_table(table_text(both), {{"radius", "r"}});
  CHECK(named.recognized == "column area is not read, because radius is named");
}

TEST_CASE("Tables of plots that contradict themselves or have gaps are not silent") {
  const Inventory stand = without_positions({{.dbh_cm = 20}});
  CHECK_THROWS_WITH(sample_of(stand, {.plots = plots_of("plot,area,radius\n1,400,5\n")}),
                    Contains("plots.csv:2: area, radius and expansion of the plot do not agree: "
                             "400 m2 or 78.5398 m2"));
  CHECK_THROWS_WITH(sample_of(stand, {.plots = plots_of("plot,area,expansion\n1,400,10\n")}),
                    Contains("400 m2 or 1000 m2"));
  // A radius of 11.28 m and four subplots of 5.64 m are 400 m2.
  CHECK_NOTHROW(sample_of(stand, {.plots = plots_of("plot,area,radius\n1,400,11.3\n")}));
  CHECK_NOTHROW(
      sample_of(stand, {.plots = plots_of("plot,area,radius\n1,400,5.64\n"), .subplots = 4}));
  const DesignedSample gaps = sample_of(
      stand, {.plots = plots_of("plot,area,slope\n1,400,\n2,,10\n"), .corrects_slope = true});
  CHECK(gaps.areas.size() == 1);
  CHECK(says(gaps.notes, "1 plot has no area in the table and not counted: 2"));
  CHECK(says(gaps.notes, "1 plot has no slope in the table and taken as level: 1"));
}

TEST_CASE("Plots have the subplots that the design counts") {
  // Four subplots with a tree each, as of a cluster.
  Inventory stand =
      without_positions({{.dbh_cm = 20}, {.dbh_cm = 20}, {.dbh_cm = 20}, {.dbh_cm = 20}});
  stand.other = data::Table(4);
  stand.other.set("sub", std::vector<double>{1.0, 2.0, 3.0, 4.0});
  SamplingDesign design{.circles = {{7, 12.62}}, .subplot = "sub"};
  CHECK_THROWS_WITH(sample_of(stand, design),
                    Contains("plot 1 has 4 subplots in column sub, but the design has 1 in a "
                             "plot; give their number with `subplots=4`"));
  design.subplots = 2;
  CHECK_THROWS_AS(sample_of(stand, design), UsageError);
  design.subplots = 5;  // one of them has no tree
  CHECK(stems_per_ha(sample_of(stand, design), 0) ==
        Approx(1e4 / (5.0 * M_PI * 12.62 * 12.62)).epsilon(1e-12));
}

TEST_CASE("Areas of plots that contradict other columns, stems or the hull are not silent") {
  const Inventory stand = without_positions({{.dbh_cm = 20}});
  CHECK_THROWS_WITH(plots_of("plot,area,area_ha\n1,800,0.05\n"),
                    Contains("area_ha 0.05 is 500 in the unit of area, which is 800"));
  CHECK(plots_of("plot,area,area_ha\n1,504,0.05\n").plots[0].area_m2 == 504.0);
  // A stem of 20 cm has 0.0314 m2.
  CHECK_THROWS_WITH(
      sample_of(stand, {.plots = plots_of("plot,area\n1,0.03\n2,500\n3,500\n")}),
      Contains("plot 1 has an area of 0.03 m2 for 1 tree, less than the 0.0314 m2 of basal area"));
  // Trees in the corners of a square of 10 m.
  const Inventory square = stand_of({{.x = 0, .y = 0, .dbh_cm = 20},
                                     {.x = 10, .y = 0, .dbh_cm = 20},
                                     {.x = 10, .y = 10, .dbh_cm = 20},
                                     {.x = 0, .y = 10, .dbh_cm = 20}});
  const std::string note =
      "1 plot has a smaller area than the convex hull of the trees (plot 1: 90 m2, hull 100 m2)";
  CHECK(says(stand_report(square, {.plot_area_m2 = 90.0}).notes, note));
  CHECK_FALSE(says(stand_report(square, {.plot_area_m2 = 101.0}).notes, "a smaller area"));
  CHECK(
      says(stand_report(square, {.design = {.plots = plots_of("plot,area\n1,90\n")}}).notes, note));
  // Twelve trees on a circle of 5 m (hull 75 m2) do not fill a plot of 4000 m2.
  std::vector<Tree> ring;
  for (int i = 0; i < 12; ++i) {
    ring.push_back({.x = 5 * std::cos(i * M_PI / 6), .y = 5 * std::sin(i * M_PI / 6)});
  }
  CHECK(says(stand_report(stand_of(ring), {.plot_area_m2 = 4000.0}).notes,
             "all trees of 1 plot stand on less than a tenth of the area (plot 1: 4000 m2"));
  CHECK_FALSE(says(stand_report(stand_of(ring), {.plot_area_m2 = 400.0}).notes, "a tenth"));
  // Two stems of 80 cm have 1 m2, which is 2513 m2/ha on 4 m2.
  const Inventory dense = without_positions(
      {{.dbh_cm = 80, .plot = "1"}, {.dbh_cm = 80, .plot = "1"}, {.dbh_cm = 20, .plot = "2"}});
  CHECK(says(stand_report(dense, {.design = {.plots = plots_of("plot,area\n1,4\n2,400\n")}}).notes,
             "1 plot has more basal area per hectare than any forest (plot 1: 2513 m2 on 4 m2)"));
}

TEST_CASE("Trees per acre are recognized by their unit") {
  for (const char* const name : {"TPA", "N per acre", "EXPF (1/ac)", "trees/acre"}) {
    Inventory stand = without_positions({{.dbh_cm = 20}});
    stand.other = data::Table(1);
    stand.other.set(name, std::vector<double>{30.0});
    // An acre has 4046.8564224 m2.
    CHECK(stems_per_ha(sample_of(stand, {.expansion = name}), 0) ==
          Approx(30.0 * 1e4 / 4046.8564224).epsilon(1e-12));
  }
  Inventory stand = without_positions({{.dbh_cm = 20}});
  stand.other = data::Table(1);
  stand.other.set("factor", std::vector<double>{30.0});
  CHECK(stems_per_ha(sample_of(stand, {.expansion = "factor"}), 0) == Approx(30.0));
}

TEST_CASE("Units in the headers of a table of plots are converted") {
  // An acre is 43,560 square feet of 0.3048^2 m2.
  CHECK(plots_of("plot,Area (ac)\n1,0.1\n").plots[0].area_m2 ==
        Approx(4356.0 * 0.3048 * 0.3048).epsilon(1e-13));
  CHECK(plots_of("plot,plot_size [ft2]\n1,4356\n").plots[0].area_m2 ==
        Approx(4356.0 * 0.3048 * 0.3048).epsilon(1e-13));
  CHECK(plots_of("plot,radius (ft)\n1,24\n").plots[0].radius_m == Approx(7.3152).epsilon(1e-13));
  CHECK(plots_of("plot,stratum,stratum_area (m2)\n1,A,50000\n").plots[0].stratum_ha ==
        Approx(5.0).epsilon(1e-14));
  CHECK(plots_of("plot,stratum,stratum area [km2]\n1,A,0.5\n").plots[0].stratum_ha ==
        Approx(50.0).epsilon(1e-14));
}

TEST_CASE("Designs that contradict themselves are refused") {
  const Inventory stand = without_positions({{.dbh_cm = 20}});
  CHECK_THROWS_WITH(sample_of(stand, {.circles = {{7, 4}}, .basal_area_factor = 4}),
                    Contains("use one of"));
  CHECK_THROWS_WITH(sample_of(stand, {.circles = {{7, 8}, {15, 4}}}), Contains("increasing"));
  CHECK_THROWS_WITH(sample_of(stand, {.basal_area_factor = 4, .subplots = 0}),
                    Contains("at least one"));
  StandReportOptions both{.design = {.basal_area_factor = 4}};
  both.plot_area_m2 = 400;
  CHECK_THROWS_WITH(stand_report(stand, both), Contains("`plot_area`"));
}

TEST_CASE("Plots outside the population count with area 0 in the ratio") {
  // Plots A (share 1) and B (0.5) with 100 and 300 trees per hectare of the whole plot, and two
  // plots with share 0. R = sum y / sum a = 400 / 1.5; residuals y - R a are -166.67, 166.67, 0, 0.
  // SE = sqrt(2 * 166.67^2 / (4 * 3)) / (1.5 / 4) (Cochran 1977, chapter 6).
  Inventory trees =
      without_positions({{.dbh_cm = 20.0, .plot = "A"}, {.dbh_cm = 20.0, .plot = "B"}});
  trees.other = data::Table(2);
  trees.other.set("tph", std::vector<double>{100.0, 300.0});
  StandReportOptions options;
  options.design.expansion = "tph";
  options.design.plots = plots_of(
      "plot,share,stratum,stratum_weight\nA,1,s,2\nB,0.5,s,2\nC,0,s,2\nD,0,s,2\nE,0,n,1\nF,0,n,"
      "1\n");
  const StandReport report = stand_report(trees, options);
  REQUIRE(report.strata.size() == 3);
  const StratumFigures& forest = report.strata[1];
  CHECK(forest.plots == 4);
  CHECK(forest.stems.per_ha == Approx(400.0 / 1.5).epsilon(1e-12));
  const double residual = 100.0 - 400.0 / 1.5;
  CHECK(forest.stems.standard_error ==
        Approx(std::sqrt(2.0 * residual * residual / 12.0) / 0.375).epsilon(1e-12));
  CHECK(std::isnan(report.strata[0].stems.per_ha));
  // The stratum without forest adds nothing to the combined ratio (Cochran 1977, 6.11).
  CHECK(report.strata[2].stems.per_ha == Approx(400.0 / 1.5).epsilon(1e-12));
  CHECK(report.strata[2].stems.standard_error ==
        Approx(forest.stems.standard_error).epsilon(1e-12));
  CHECK(says(report.notes, "4 plots of the table have share 0"));

  // Factors per hectare of the part: A 100 and B 300, weighted with the shares.
  options.design.is_expansion_of_part = true;
  CHECK(stand_report(trees, options).strata[1].stems.per_ha ==
        Approx((100.0 + 0.5 * 300.0) / 1.5).epsilon(1e-12));
}

TEST_CASE("A table of plots without any plot of the inventory is an error") {
  const Inventory trees = without_positions({{.dbh_cm = 20.0, .plot = "A"}});
  const SamplingDesign design{.plots = plots_of("plot,area\na1,400\na2,400\n")};
  CHECK_THROWS_WITH(sample_of(trees, design), Contains("no plot of the inventory is in the table"));
  CHECK_THROWS_AS(plots_of("plot,share\nA,50\n"), InputError);
  CHECK(plots_of("plot,share,stratum,stratum_weight\nA,1.03,s,0\n").plots[0].share == 1.03);
}

TEST_CASE("Areas that make impossible basal areas are an error") {
  const Inventory trees = without_positions({{.dbh_cm = 30.0}});
  CHECK_THROWS_WITH(stand_report(trees, {.plot_area_m2 = 0.05}), Contains("areas are in m2"));
  CHECK_NOTHROW(stand_report(trees, {.plot_area_m2 = 0.05, .trust_units = true}));
}
