// SPDX-License-Identifier: MIT
// The whole report of a stand: the trees and plots that it counts, and its notes on the others.
#include "silvafit/stand/stand_report.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "reference.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/inventory_test_support.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;
using silvafit::test::reference_data;

namespace {

std::string notes_in(const StandReport& report) {
  std::string all;
  for (const std::string& note : report.notes) all += note + "\n";
  return all;
}

}  // namespace

TEST_CASE("crown cover is that of the trees with a crown width, and others are counted") {
  Inventory stand = stand_of({{.x = 0, .y = 0, .cw_m = 2},
                              {.x = 9, .y = 0, .cw_m = NAN},
                              {.x = 9, .y = 9, .cw_m = 4},
                              {.x = 0, .y = 9, .cw_m = NAN}});
  const StandFigures figures = stand_figures(stand, all_rows(stand), 100.0);
  // pi / 4 (4 + 16) m2 of 100 m2
  CHECK(figures.crown_cover_percent == Approx(5.0 * M_PI).epsilon(1e-14));
  CHECK(figures.trees_without_crown_width == 2);
  const auto notes_of = [&stand] {
    std::string all;
    StandReportOptions options{.units = {.neighbors = 1}};
    options.plot_area_m2 = 100.0;
    for (const std::string& note : stand_report(stand, options).notes) all += note + "\n";
    return all;
  };
  CHECK_THAT(notes_of(),
             Contains("2 of 4 trees have no crown width and are not included in the crown "
                      "cover, which is therefore too small"));
  stand.cw_m[1] = 3;
  CHECK_THAT(notes_of(),
             Contains("1 of 4 trees has no crown width and is not included in the crown cover"));
  stand.cw_m[3] = 3;
  CHECK_THAT(notes_of(), !Contains("crown cover"));
  // Where none is known, neither is the cover.
  stand.cw_m.assign(4, NAN);
  CHECK(std::isnan(stand_figures(stand, all_rows(stand), 100.0).crown_cover_percent));
  CHECK_THAT(notes_of(), !Contains("crown cover"));
  stand.cw_m.clear();
  CHECK(std::isnan(stand_figures(stand, {}, 100.0).crown_cover_percent));
}

TEST_CASE("a report counts plots without trees, and notes what it skips") {
  Inventory stand = stand_of({{.x = 1, .plot = "1"},
                              {.x = 3, .plot = "1"},
                              {.x = 99, .plot = "1"},
                              {.x = 21, .plot = "2"}});
  StandReportOptions options{.units = {.neighbors = 1,
                                       .windows = {{"1", Window::rectangle({0, -10}, {20, 10})},
                                                   {"2", Window::rectangle({20, -10}, {40, 10})},
                                                   {"3", Window::rectangle({40, -10}, {60, 10})}}}};
  const StandReport report = stand_report(stand, options);
  REQUIRE(report.areas.size() == 3);
  CHECK(report.areas[2].area.name == "3");
  CHECK(report.areas[2].figures.stems_per_ha == 0.0);
  CHECK(report.all.stems_per_ha == Approx(3.0 / 0.12).epsilon(1e-14));
  CHECK(report.strata.back().stems.per_ha == Approx(25.0).epsilon(1e-14));
  const std::string notes = std::accumulate(
      report.notes.begin(), report.notes.end(), std::string(), [](auto all, const auto& note) {
        return all + note + "\n";
      });
  CHECK_THAT(notes,
             Contains("1 tree outside the windows is not counted, but is used as a neighbor\n"));
  CHECK_THAT(notes, !Contains("outside the window:"));
  CHECK_THAT(notes, Contains("1 plot with a window has no tree"));

  CHECK_THROWS_WITH(
      stand_report(stand_of({{.x = 1}, {.x = 2}}), {}),
      Contains("no plot has an area") && Contains("`window`") && Contains("`plot_area`"));

  stand.x.clear();
  stand.y.clear();
  CHECK_THROWS_WITH(stand_report(stand, {}), Contains("`plot_area`"));
  const StandReport by_area = stand_report(stand, {.plot_area_m2 = 500.0});
  CHECK_FALSE(by_area.units);
  CHECK(by_area.all.stems_per_ha == Approx(40.0).epsilon(1e-14));
}

TEST_CASE("the simulated inventory has the densities of the paper's Table 1", "[reference]") {
  const Inventory inventory = read_inventory(reference_data("fir_mixed/inventory.csv")).inventory;
  const StandReport report = stand_report(
      inventory,
      {.units = {.scope = SearchScope::kStand,
                 .windows = read_windows(reference_data("fir_mixed/window.geojson"))}});
  REQUIRE(report.areas.size() == 1);
  CHECK(report.areas[0].figures.area_ha == 5.0);
  // Table 1 of the paper, trees per hectare with one digit.
  const std::vector<std::pair<std::string, double>> densities{{"SM", 273.0},
                                                              {"BHN", 252.6},
                                                              {"MH", 259.0},
                                                              {"OF", 62.0},
                                                              {"MF", 48.0},
                                                              {"VF", 35.6},
                                                              {"LF", 27.0},
                                                              {"SD", 21.8}};
  double sum = 0.0;
  for (const auto& [species, density] : densities) {
    const SpeciesRow& row = row_of(report.species, species);
    CHECK(row.figures.stems_per_ha == Approx(density).epsilon(1e-12));
    sum += row.all.value;
  }
  CHECK(sum == Approx(100.0).epsilon(1e-12));
  // The ranks of the three dominant species, with a clear gap to the others, as in the paper.
  CHECK(report.species[0].species == "SM");
  CHECK(report.species[2].all.value > 2.0 * report.species[3].all.value);
  // in_core of fir_mixed_indices.csv
  CHECK(report.unit_means->core_trees == 4445);
}

TEST_CASE("a stratum of one plot has no standard error, and a note says why") {
  Inventory stand = stand_of({{.dbh_cm = 10}, {.dbh_cm = 20}, {.dbh_cm = 30}});
  stand.plot = {};
  silvafit::data::TextColumn strata;
  for (const char* plot : {"1", "2", "3"}) stand.plot.append(plot);
  for (const char* stratum : {"A", "A", "B"}) strata.append(stratum);
  stand.other = silvafit::data::Table(3);
  stand.other.set("zone", strata);
  StandReportOptions options{.plot_area_m2 = 100.0, .stratum = "zone"};
  const auto notes_on_plots = [&] {
    std::string found;
    for (const std::string& note : stand_report(stand, options).notes) {
      if (note.find("one plot") != std::string::npos) found += note;
    }
    return found;
  };
  // Without the strata's areas all plots are one sample, which has a variance.
  CHECK(notes_on_plots() ==
        "the stratum B has only one plot; a variance needs two plots, so it has no standard error");
  options.stratum_areas_ha = {{"A", 3.0}, {"B", 2.0}};
  CHECK_THAT(notes_on_plots(),
             Catch::Matchers::EndsWith(", and neither has the total over all strata"));
  options.stratum_areas_ha.clear();
  options.stratum = "plot";
  CHECK_THAT(notes_on_plots(),
             Catch::Matchers::StartsWith("the strata 1, 2, 3 each have only one plot"));
  options.stratum.clear();
  CHECK(notes_on_plots().empty());
}

TEST_CASE("plots without a stratum have a row of their own, with a note") {
  Inventory stand = stand_of({{.plot = "1"}, {.plot = "2"}, {.plot = "2"}, {.plot = "3"}});
  silvafit::data::TextColumn strata;
  for (const char* stratum : {"all", "B", "B"}) strata.append(stratum);
  strata.append_missing();
  stand.other = silvafit::data::Table(4);
  stand.other.set("zone", strata);
  StandReportOptions options{.plot_area_m2 = 100.0, .stratum = "zone"};
  using Kind = StratumFigures::Kind;
  const StandReport report = stand_report(stand, options);
  REQUIRE(report.strata.size() == 4);
  CHECK(report.strata[1].name == "all");
  CHECK(report.strata[1].kind == Kind::kStratum);
  CHECK(report.strata[2].kind == Kind::kWithout);
  CHECK(report.strata[2].trees == 1);
  CHECK(report.strata[3].kind == Kind::kAll);
  // Four trees on three ares.
  CHECK(report.strata[3].stems.per_ha == Approx(4.0 / 0.03).epsilon(1e-14));
  CHECK_THAT(notes_in(report), Contains("plot 3 has no stratum in the column zone"));
  CHECK_THAT(notes_in(report), Contains("the strata B, all, (none) each have only one plot"));

  // Weighted by areas: 200 stems per ha on 4 ha, 100 on 1 ha; plot 3 stands for no area.
  options.stratum_areas_ha = {{"B", 4.0}, {"all", 1.0}};
  const StandReport weighted = stand_report(stand, options);
  CHECK(weighted.strata[3].plots == 2);
  CHECK(weighted.strata[3].stems.total == Approx(900.0).epsilon(1e-14));
  CHECK(std::isnan(weighted.strata[2].stems.total));
  CHECK_THAT(notes_in(weighted), Contains("which the row of all strata does not include"));
}

TEST_CASE("a note names plots without a hull, and their trees are not outside") {
  const Inventory stand = stand_of({{},
                                    {.x = 10},
                                    {.y = 10},
                                    {.plot = "pair"},
                                    {.x = 1, .plot = "pair"},
                                    {.plot = "line"},
                                    {.x = 1, .plot = "line"},
                                    {.x = 2, .plot = "line"}});
  const StandReport report = stand_report(stand, {.units = {.neighbors = 1}});
  CHECK(report.areas.size() == 1);
  CHECK(report.all.trees == 3);
  CHECK_THAT(notes_in(report), Contains("2 plots are not counted, with 5 trees: plot pair, line"));
  CHECK_THAT(notes_in(report), !Contains("outside"));
}

TEST_CASE("a plot all of whose rows were skipped is not a plot without trees") {
  const silvafit::test::ScratchFile file(
      "plot,tree,species,x,y,dbh\n1,1,A,1,1,10\n2,1,A,1,1,-1\n2,2,A,1,1,-1\n", ".csv");
  const Inventory stand = read_inventory(file.path(), {.trust_units = true}).inventory;
  CHECK(stand.plots_left_out == std::vector<std::string>{"2"});
  const Window square = Window::rectangle({0, 0}, {10, 10});
  const StandReportOptions by_window{
      .units = {.neighbors = 1, .windows = {{"1", square}, {"2", square}}}};
  const StandReportOptions by_area{.units = {.neighbors = 1}, .plot_area_m2 = 100.0};
  for (const StandReportOptions& options : {by_window, by_area}) {
    const StandReport report = stand_report(stand, options);
    CHECK(report.all.stems_per_ha == Approx(100.0).epsilon(1e-14));
    CHECK_THAT(notes_in(report), Contains("plot 2 is treated as unknown and not counted"));
    CHECK_THAT(notes_in(report), !Contains("no tree"));
  }
}

TEST_CASE("a plot without a living tree has no stratum by a column of the trees") {
  Inventory stand = stand_of({{.plot = "1"}, {.plot = "2"}});
  silvafit::data::TextColumn strata;
  for (const char* stratum : {"X", "Y"}) strata.append(stratum);
  stand.other = silvafit::data::Table(2);
  stand.other.set("zone", strata);
  stand.plots_without_trees = {"3"};
  StandReportOptions options{.plot_area_m2 = 500.0};
  // Two trees on three plots of 500 m2.
  CHECK(stand_report(stand, options).all.stems_per_ha == Approx(2.0 / 0.15).epsilon(1e-14));
  options.stratum = "zone";
  CHECK_THROWS_WITH(
      stand_report(stand, options),
      Contains("no living tree that tells its stratum by the column zone") && Contains("(plot 3)"));
}

TEST_CASE("a table of plots beside windows has neither shares nor other areas") {
  const Inventory stand = stand_of({{.plot = "1"}, {.x = 1, .plot = "2"}});
  const Window square = Window::rectangle({-5, -5}, {15, 20});
  StandReportOptions options{.units = {.neighbors = 1, .windows = {{"1", square}, {"2", square}}}};
  options.design.plots = PlotTable{.file = "plots.csv", .plots = {{.plot = "1"}, {.plot = "6"}}};
  CHECK_THAT(notes_in(stand_report(stand, options)),
             Contains("1 plot of the table has neither a tree nor a window and is not counted: 6"));
  options.design.plots->plots[0].share = 0.5;
  CHECK_THROWS_WITH(stand_report(stand, options), Contains("share of the table of plots is not"));
  options.design.plots->plots[0].share = 1.0;
  options.design.plots->plots[0].area_m2 = 400.0;
  CHECK_THROWS_WITH(stand_report(stand, options),
                    Contains("400 m2 in the table of plots, and 500 m2 by"));
}

TEST_CASE("trees with an expansion factor of 0 change no mean") {
  const auto figures_of = [](const std::string& rows) {
    const CheckedInventory read =
        read_inventory_text("plot,tree,dbh,h,f\n" + rows, {.keep = {"f"}});
    return stand_report(read.inventory, {.design = {.expansion = "f"}}).all;
  };
  for (const std::string rows : {"1,1,30,20,0\n1,2,20,15,100\n1,3,25,18,100\n",
                                 "1,2,20,15,100\n1,3,25,18,100\n1,1,30,20,0\n"}) {
    const StandFigures figures = figures_of(rows);
    CHECK(figures.mean_dbh_cm == Approx(22.5).epsilon(1e-14));
    CHECK(figures.mean_height_m == Approx(16.5).epsilon(1e-14));
    CHECK(figures.dominant_height_m == Approx(18.0).epsilon(1e-14));
  }
}

TEST_CASE("a plot area replaces a window, and quadrats need a window") {
  const Inventory stand = stand_of({{}, {.x = 10}, {.y = 10, .dbh_cm = 30}});
  StandReportOptions options{.units = {.neighbors = 1}, .plot_area_m2 = 500.0};
  options.units.further = {FurtherIndex::kBasalAreaLarger};
  const StandReport report = stand_report(stand, options);
  CHECK(report.units->further[0].values[0] == Approx(basal_area_m2(30) / 0.05).epsilon(1e-14));
  CHECK_THAT(notes_in(report), !Contains("BAL"));
  options.species.quadrat_m = 5.0;
  CHECK_THROWS_WITH(stand_report(stand, options), Contains("quadrats need windows"));
  options.units.windows = {{kEveryPlot, Window::circle({0, 0}, 12.0)}};
  CHECK_THROWS_WITH(stand_report(stand, options), Contains("use either `plot_area` or windows"));
}

TEST_CASE("a note counts the thickest trees without height by plot") {
  // 100 a hectare are two on 200 m2.
  Inventory stand = stand_of({{.dbh_cm = 40, .h_m = NAN},
                              {.dbh_cm = 30, .h_m = 20},
                              {.dbh_cm = 20, .h_m = 15},
                              {.dbh_cm = 20, .plot = "2", .h_m = 15}});
  const StandReport report = stand_report(stand, {.plot_area_m2 = 200.0});
  const StandFigures& first = report.areas[0].figures;
  CHECK(first.dominant_height_m == 20.0);
  CHECK(first.dominant_trees == 2);
  CHECK(first.dominant_trees_without_height == 1);
  CHECK_THAT(notes_in(report),
             Contains("mean of the others: 1 (1 of 2); to impute heights, use `silvafit impute`"));
  stand.h_m[0] = 22.0;
  CHECK_THAT(notes_in(stand_report(stand, {.plot_area_m2 = 200.0})), !Contains("thickest"));
  stand.h_m.clear();
  CHECK_THAT(notes_in(stand_report(stand, {.plot_area_m2 = 200.0})), !Contains("thickest"));
}

TEST_CASE("expansion factors that differ within a plot are not left aside") {
  for (const std::string name : {"TPH", "stems_ha", "N/ha", "trees per ha", "TPA", "Arb_ha"}) {
    const auto factors = [&](const std::string& second) {
      return read_inventory_text("plot,tree,dbh," + name + "\n1,1,20,100\n1,2,40," + second + "\n")
          .inventory;
    };
    CHECK(factors("100").factors.column == name);
    CHECK_NOTHROW(stand_report(factors("100"), {.plot_area_m2 = 100.0}));
    CHECK_THROWS_WITH(stand_report(factors("25"), {.plot_area_m2 = 100.0}),
                      Contains("stand for different numbers of trees per ha, 100 and 25") &&
                          Contains("`expansion=" + name + "`"));
    CHECK_THROWS_WITH(stand_report(factors("100"), {}), Contains("`expansion=" + name + "`"));
  }
  // 404.7 m2 an acre: 20 trees per acre are 49.4 per hectare.
  const CheckedInventory acres =
      read_inventory_text("plot,tree,dbh,exp_ac\n1,1,20,20\n", {.keep = {"exp_ac"}});
  CHECK(stand_report(acres.inventory, {.design = {.expansion = "exp_ac"}})
            .areas.at(0)
            .figures.stems_per_ha == Approx(20 / 0.40468564224).epsilon(1e-12));
  const CheckedInventory factor =
      read_inventory_text("plot,tree,dbh,BAF\n1,1,20,4\n", {.keep = {"BAF"}});
  CHECK_THROWS_WITH(stand_report(factor.inventory, {.design = {.expansion = "BAF"}}),
                    Contains("use `angle_count`"));
  CHECK(read_inventory_text("plot,dbh,mha\n1,20,3\n").inventory.factors.column.empty());
}
