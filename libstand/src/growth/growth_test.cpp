// SPDX-License-Identifier: MIT
// Growth between measurements, against values worked out by hand and the balance of its parts.
#include "silvafit/stand/growth.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/inventory.hpp"
#include "test_support/stand_test_support.hpp"
#include "trees/measurement_time.hpp"

using namespace silvafit;
using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

namespace {

data::TableSource csv_of(const std::string& text, const std::string& name = "growth.csv") {
  return std::make_shared<const data::TableText>(
      data::TableText{.name = name, .text = text, .separator = ','});
}

CheckedInventory measured(const std::string& text) {
  return read_inventory(csv_of(text), {.keeps_measurements = true});
}

double value_of(const PlotGrowth& plot, std::size_t value, GrowthPart part) {
  return plot.values[value][static_cast<std::size_t>(part)];
}

const Estimate& estimate_in(const StratumGrowth& stratum, std::size_t value, GrowthPart part) {
  return stratum.values[value][static_cast<std::size_t>(part)];
}

bool tells(const std::vector<std::string>& notes, const std::string& text) {
  return std::ranges::any_of(
      notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
}

/// End = start + years times the sum of the changes.
void check_balance(const PlotGrowth& plot) {
  for (std::size_t value = 0; value < plot.values.size(); ++value) {
    const double change = value_of(plot, value, GrowthPart::kSurvivorGrowth) +
                          value_of(plot, value, GrowthPart::kIngrowth) -
                          value_of(plot, value, GrowthPart::kMortality) -
                          value_of(plot, value, GrowthPart::kCut) -
                          value_of(plot, value, GrowthPart::kNotFound) +
                          value_of(plot, value, GrowthPart::kFactorChange);
    CHECK(value_of(plot, value, GrowthPart::kEnd) ==
          Approx(value_of(plot, value, GrowthPart::kStart) + plot.years * change).epsilon(1e-12));
  }
}

// A survivor, one that dies, one that is cut, one that is not found, and one that grows in.
const char* const kFates =
    "plot,tree,species,year,dbh,h,status\n"
    "1,1,A,2010,20,15,alive\n1,2,A,2010,10,9,alive\n1,3,B,2010,30,20,alive\n"
    "1,4,B,2010,12,10,alive\n"
    "1,1,A,2015,22.5,16,alive\n1,2,A,2015,,,dead\n1,3,B,2015,,,cut\n1,5,A,2015,7,6,alive\n";

}  // namespace

TEST_CASE("Every tree of a period has one fate, and its increments are differences per year") {
  const CheckedInventory checked = measured(kFates);
  CHECK(checked.excluded_tree_count == 0);
  StandReportOptions options;
  options.plot_area_m2 = 500.0;
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.trees.size() == 5);
  std::vector<std::string> fates;
  for (const TreeGrowth& tree : report.trees) {
    fates.push_back(tree.tree + " " + std::string(silvafit::word_of(tree.fate)));
  }
  CHECK(fates == std::vector<std::string>{
                     "1 survivor", "2 mortality", "3 cut", "4 not found", "5 ingrowth"});
  const TreeGrowth& survivor = report.trees[0];
  CHECK(survivor.years == 5.0);
  CHECK(survivor.dbh_cm_per_year == Approx(0.5).epsilon(1e-14));
  CHECK(survivor.h_m_per_year == Approx(0.2).epsilon(1e-14));
  // pi/4 (22.5^2 - 20^2) / 5
  CHECK(survivor.basal_area_cm2_per_year == Approx(M_PI / 4 * 106.25 / 5).epsilon(1e-13));
  CHECK(std::isnan(report.trees[4].dbh_cm_per_year));
  CHECK(tells(report.notes, "1 tree has no row at the end of a period"));

  REQUIRE(report.plots.size() == 1);
  const PlotGrowth& plot = report.plots[0];
  // 20 trees per ha each.
  CHECK(value_of(plot, 0, GrowthPart::kStart) == Approx(80.0).epsilon(1e-14));
  CHECK(value_of(plot, 0, GrowthPart::kEnd) == Approx(40.0).epsilon(1e-14));
  CHECK(value_of(plot, 0, GrowthPart::kNetChange) == Approx(-8.0).epsilon(1e-14));
  CHECK(value_of(plot, 0, GrowthPart::kSurvivorGrowth) == 0.0);
  for (const GrowthPart part :
       {GrowthPart::kIngrowth, GrowthPart::kMortality, GrowthPart::kCut, GrowthPart::kNotFound}) {
    CHECK(value_of(plot, 0, part) == Approx(4.0).epsilon(1e-14));
  }
  CHECK(value_of(plot, 1, GrowthPart::kSurvivorGrowth) ==
        Approx(20 * (basal_area_m2(22.5) - basal_area_m2(20)) / 5).epsilon(1e-12));
  CHECK(value_of(plot, 1, GrowthPart::kCut) == Approx(20 * basal_area_m2(30) / 5).epsilon(1e-13));
  CHECK(value_of(plot, 1, GrowthPart::kFactorChange) == 0.0);
  check_balance(plot);
}

TEST_CASE("A tree with another species later counts for the first one and is named") {
  StandReportOptions options;
  options.plot_area_m2 = 500.0;
  const GrowthReport report = growth_report(measured("plot,tree,species,year,dbh,h\n"
                                                     "1,1,A,2010,20,15\n1,2,B,2010,10,9\n"
                                                     "1,1,A,2015,22,16\n1,2,C,2015,12,10\n")
                                                .inventory,
                                            options);
  CHECK(report.trees[1].species == "B");
  CHECK(tells(report.notes, "plot 1, tree 2 (B in 2010, C in 2015)"));
  CHECK_FALSE(tells(report.notes, "tree 1 ("));
}

TEST_CASE("Without keeping measurements an inventory has the trees of the last visit") {
  const CheckedInventory last = read_inventory(csv_of(kFates), {});
  CHECK(last.inventory.dbh_cm == std::vector<double>{22.5, 7});
  CHECK(last.inventory.time.size() == 0);
}

TEST_CASE("A measurement that is missing between two others is interpolated") {
  const CheckedInventory checked = measured(
      "plot,tree,year,dbh\n1,1,2000,10\n1,2,2000,30\n1,2,2004,31\n1,1,2010,20\n1,2,2010,33\n");
  StandReportOptions options;
  options.plot_area_m2 = 1000.0;
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.trees.size() == 4);
  CHECK(report.trees[0].dbh_end_cm == Approx(14.0).epsilon(1e-14));
  CHECK(report.trees[0].is_interpolated);
  CHECK(report.trees[0].fate == TreeFate::kSurvivor);
  CHECK(report.plots.size() == 2);
  CHECK(value_of(report.plots[1], 0, GrowthPart::kIngrowth) == 0.0);
  CHECK(tells(report.notes, "1 measurement is missing"));
  for (const PlotGrowth& plot : report.plots) check_balance(plot);
}

TEST_CASE("An empty dbh is completed as a missing row is, and is the last one before death") {
  // Tree 2 has 28 cm in 2000 and 32 cm in 2015; tree 3 has 18 cm and is dead in 2010.
  const CheckedInventory checked = measured(
      "plot,tree,year,dbh,status\n1,1,2000,20,alive\n1,1,2005,21,alive\n1,1,2010,22,alive\n"
      "1,1,2015,23,alive\n1,2,2000,28,alive\n1,2,2005,,alive\n1,2,2015,32,alive\n"
      "1,3,2000,18,alive\n1,3,2005,,alive\n1,3,2010,,dead\n");
  const GrowthReport report =
      growth_report(checked.inventory, {.design = {.circles = {{7, 4}, {15, 8}}}});
  const double factor = 1e4 / (M_PI * 64);
  REQUIRE(report.plots.size() == 3);
  CHECK(value_of(report.plots[0], 0, GrowthPart::kEnd) == Approx(3 * factor).epsilon(1e-13));
  const PlotGrowth& second = report.plots[1];
  CHECK(value_of(second, 0, GrowthPart::kMortality) == Approx(factor / 5).epsilon(1e-13));
  CHECK(value_of(second, 1, GrowthPart::kMortality) ==
        Approx(factor * basal_area_m2(18) / 5).epsilon(1e-13));
  const double dbh_2010 = 28.0 + 4.0 * 10.0 / 15.0;
  CHECK(value_of(second, 1, GrowthPart::kEnd) ==
        Approx(factor * (basal_area_m2(22) + basal_area_m2(dbh_2010))).epsilon(1e-13));
  for (const PlotGrowth& plot : report.plots) check_balance(plot);
  CHECK(tells(report.notes, "2 measurements are missing"));
  CHECK(tells(report.notes, "1 row has no dbh before the tree died"));
}

TEST_CASE("A tree that grows over a limit of concentric circles changes its factor") {
  // Van Deusen and others 1986: growth of survivors by the factor at the start is unbiased; the
  // rest of the net change is that of factors.
  const CheckedInventory checked =
      measured("plot,tree,year,dbh\n1,1,2010,29\n1,2,2010,40\n1,1,2020,31\n1,2,2020,45\n");
  const GrowthReport report =
      growth_report(checked.inventory, {.design = {.circles = {{7, 5}, {30, 10}}}});
  const double small = 1e4 / (M_PI * 25);
  const double large = 1e4 / (M_PI * 100);
  const PlotGrowth& plot = report.plots[0];
  CHECK(value_of(plot, 0, GrowthPart::kStart) == Approx(small + large).epsilon(1e-13));
  CHECK(value_of(plot, 0, GrowthPart::kEnd) == Approx(2 * large).epsilon(1e-13));
  CHECK(value_of(plot, 0, GrowthPart::kFactorChange) ==
        Approx((large - small) / 10).epsilon(1e-12));
  CHECK(value_of(plot, 1, GrowthPart::kSurvivorGrowth) ==
        Approx((small * (basal_area_m2(31) - basal_area_m2(29)) +
                large * (basal_area_m2(45) - basal_area_m2(40))) /
               10)
            .epsilon(1e-12));
  check_balance(plot);
}

TEST_CASE("Growth of strata has the standard errors of samples, with empty plots") {
  const CheckedInventory checked = measured(
      "plot,tree,year,dbh\n1,1,2010,20\n1,1,2020,20\n1,2,2020,20\n2,1,2010,20\n2,1,2020,20\n"
      "3,1,2012,20\n3,1,2022,20\n3,2,2022,20\n3,3,2022,20\n");
  StandReportOptions options;
  options.design.plots = read_plot_table(
      csv_of("plot,year,area,stratum,stratum_area\n1,2010,1000,A,20\n1,2020,1000,A,20\n"
             "2,2010,1000,A,20\n2,2020,1000,A,20\n3,2012,1000,B,10\n3,2022,1000,B,10\n"
             "4,2012,1000,B,10\n4,2022,1000,B,10\n",
             "plots.csv"));
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.plots.size() == 4);
  REQUIRE(report.strata.size() == 3);
  // Ingrowth per ha and year: 1 and 0 in A, 2 and 0 in B.
  const Estimate& a = estimate_in(report.strata[0], 0, GrowthPart::kIngrowth);
  CHECK(a.per_ha == Approx(0.5).epsilon(1e-13));
  CHECK(a.standard_error == Approx(0.5).epsilon(1e-13));
  CHECK(a.total == Approx(10.0).epsilon(1e-13));
  const StratumGrowth& all = report.strata[2];
  CHECK(all.from == "2010");
  CHECK(all.to == "2022");
  const Estimate& total = estimate_in(all, 0, GrowthPart::kIngrowth);
  CHECK(total.total == Approx(20.0).epsilon(1e-13));
  CHECK(total.total_standard_error == Approx(std::hypot(10.0, 10.0)).epsilon(1e-13));
}

TEST_CASE("With plots outside the population, areas of strata in growth are those of all land") {
  const CheckedInventory checked =
      measured("plot,tree,year,dbh\n1,1,2010,20\n1,1,2020,20\n1,2,2020,20\n");
  const std::string shares = "1,2010,1000,1,A\n1,2020,1000,1,A\n2,2010,1000,0,A\n2,2020,1000,0,A\n";
  const auto growth = [&](StandReportOptions options) {
    options.design.plots =
        read_plot_table(csv_of("plot,year,area,share,stratum\n" + shares, "plots.csv"));
    return growth_report(checked.inventory, options);
  };
  const GrowthReport report = growth({.stratum_areas_ha = {{"A", 20.0}}});
  // One tree in 10 years on 0.1 ha of the population; of the 20 ha of land, half are population.
  const Estimate& ingrowth = estimate_in(report.strata[0], 0, GrowthPart::kIngrowth);
  CHECK(ingrowth.per_ha == Approx(1.0).epsilon(1e-13));
  CHECK(ingrowth.total == Approx(10.0).epsilon(1e-13));
  CHECK(tells(report.notes, "areas of strata are taken as those of all land"));
  CHECK(!tells(growth({}).notes, "all land"));
}

TEST_CASE("Areas that make impossible basal areas are errors of growth") {
  const CheckedInventory checked = measured("plot,tree,year,dbh\n1,1,2010,20\n1,1,2020,21\n");
  // pi / 4 * 0.2^2 m2 on 0.05 m2, 1e4 m2 per ha.
  CHECK_THROWS_WITH(growth_report(checked.inventory, {.plot_area_m2 = 0.05}),
                    Contains("6283 m2 of basal area per hectare"));
  CHECK_NOTHROW(growth_report(checked.inventory, {.plot_area_m2 = 0.05, .trust_units = true}));
}

TEST_CASE("A tree that is alive later was not dead before") {
  const CheckedInventory checked = measured(
      "plot,tree,year,dbh,status\n1,1,2010,25,dead\n1,1,2015,26,alive\n1,2,2010,20,alive\n"
      "1,2,2015,,dead\n1,2,2020,24,alive\n1,1,2020,27,alive\n");
  const GrowthReport report = growth_report(checked.inventory, {.plot_area_m2 = 400.0});
  for (const TreeGrowth& tree : report.trees) CHECK(tree.fate == TreeFate::kSurvivor);
  CHECK(report.trees[0].dbh_cm_per_year == Approx(0.2).epsilon(1e-13));
  // Between 20 and 24 cm.
  CHECK(report.trees[1].dbh_end_cm == Approx(22.0).epsilon(1e-13));
  CHECK(tells(report.notes, "2 statuses are not used"));
  for (const PlotGrowth& plot : report.plots) check_balance(plot);
}

TEST_CASE("Visits in different units are refused, and single impossible increments named") {
  const auto growth_of = [](const std::string& rows, bool trusts) {
    return growth_report(measured("plot,tree,year,dbh\n" + rows).inventory,
                         {.plot_area_m2 = 1000.0, .trust_units = trusts});
  };
  const std::string first = "1,1,2010,20\n1,2,2010,30\n1,3,2010,25\n";
  const std::string millimeters = first + "1,1,2015,240\n1,2,2015,320\n1,3,2015,270\n";
  CHECK_THROWS_WITH(growth_of(millimeters, false),
                    Contains("growth.csv: dbh: from 2010 to 2015") && Contains("(plot 1)"));
  CHECK_NOTHROW(growth_of(millimeters, true));
  CHECK_THROWS_AS(growth_of(first + "1,1,2015,9\n1,2,2015,13\n1,3,2015,11\n", false), InputError);
  const GrowthReport one = growth_of(first + "1,1,2015,22\n1,2,2015,330\n1,3,2015,27\n", false);
  CHECK(tells(one.notes, "plot 1, tree 2 (30 to 330 cm, 2010 to 2015)"));
}

TEST_CASE("Copies and second stems are distinguished at each time") {
  const CheckedInventory checked = measured(
      "plot,tree,x,y,year,dbh\n1,1,0,0,2010,20\n1,1,0,0,2010,20\n1,1,0,0,2010,12\n"
      "1,1,0,0,2015,21\n1,1,0,0,2015,13\n");
  CHECK(checked.excluded_tree_count == 1);
  CHECK(checked.excluded[0].plot == "1");
  StandReportOptions options;
  options.plot_area_m2 = 100.0;
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.trees.size() == 2);
  CHECK(report.trees[0].dbh_end_cm == 21.0);
  CHECK(report.trees[1].tree == "1#2");
  CHECK(report.trees[1].dbh_end_cm == 13.0);
}

TEST_CASE("Stems are followed by their labels, else by the order of their dbh") {
  // The thicker stem grew from 30 to 33 cm, the other from 10 to 12 cm, or was not found.
  const auto growth_of = [](const std::string& text) {
    return growth_report(measured(text).inventory, {.plot_area_m2 = 500.0});
  };
  for (const char* const rows : {"1,1,a,2000,30\n1,1,b,2000,10\n1,1,b,2005,12\n1,1,a,2005,33\n",
                                 "1,1,b,2005,12\n1,1,b,2000,10\n1,1,a,2005,33\n1,1,a,2000,30\n"}) {
    for (const char* const header : {"plot,tree,stem,year,dbh\n", "plot,tree,mark,year,dbh\n"}) {
      const GrowthReport report = growth_of(header + std::string(rows));
      REQUIRE(report.trees.size() == 2);
      std::vector<double> increments;
      for (const TreeGrowth& tree : report.trees) {
        increments.push_back(tree.dbh_end_cm - tree.dbh_start_cm);
      }
      std::ranges::sort(increments);
      CHECK(increments == std::vector{2.0, 3.0});
    }
  }
  // The first stem died. As one tree it would have grown by 22 cm.
  const GrowthReport report =
      growth_of("plot,tree,stem,year,dbh\n1,1,1,2000,10\n1,1,2,2000,30\n1,1,2,2005,32\n");
  REQUIRE(report.trees.size() == 2);
  CHECK(report.trees[0].fate == TreeFate::kNotFound);
  CHECK(report.trees[1].tree == "1#2");
  CHECK(report.trees[1].dbh_end_cm - report.trees[1].dbh_start_cm == 2.0);
}

TEST_CASE("Trees that are numbered within subplots are followed by both numbers") {
  const std::string text =
      "plot,sub,tree,year,dbh\n1,1,1,2000,30\n1,2,1,2000,15\n1,1,1,2005,33\n1,2,1,2005,40\n";
  const auto increments = [&](const std::string& subplot) {
    const GrowthReport report = growth_report(
        read_inventory(csv_of(text), {.keeps_measurements = true, .subplot = subplot}).inventory,
        {.plot_area_m2 = 500.0, .trust_units = true});
    std::vector<double> found;
    for (const TreeGrowth& one : report.trees) found.push_back(one.dbh_end_cm - one.dbh_start_cm);
    std::ranges::sort(found);
    return found;
  };
  CHECK(increments("sub") == std::vector{3.0, 25.0});
  // Without the subplots, the thickest tree is taken for the thickest.
  CHECK(increments("") == std::vector{10.0, 18.0});
}

TEST_CASE("A condition does not lose the fates of trees") {
  const std::string text =
      "plot,tree,year,dbh,status\n1,1,2000,30,alive\n1,1,2005,,dead\n"
      "1,2,2000,5,alive\n1,2,2005,8,alive\n1,3,2000,20,alive\n1,3,2005,21,alive\n";
  const auto fates = [&](const std::string& condition) {
    return growth_report(
        read_inventory(csv_of(text), {.where = condition, .keeps_measurements = true}).inventory,
        {.plot_area_m2 = 500.0});
  };
  CHECK_THROWS_WITH(fates("dbh >= 7"), Contains("1 row has no value of a column of the condition"));
  const GrowthReport report = fates("dbh >= 7 || status == 'dead'");
  CHECK(value_of(report.plots[0], 0, GrowthPart::kMortality) == Approx(20.0 / 5.0));
  CHECK(value_of(report.plots[0], 0, GrowthPart::kIngrowth) == Approx(20.0 / 5.0));
  // The only fir was cut before the second visit, of which the condition leaves no row.
  const CheckedInventory firs = read_inventory(
      csv_of("plot,tree,species,year,dbh\n1,1,fir,2000,30\n1,2,oak,2000,20\n1,2,oak,2005,22\n"
             "2,1,fir,2000,30\n2,1,fir,2005,33\n"),
      {.where = "species == 'fir'", .keeps_measurements = true});
  CHECK(tells(firs.notes,
              "1 of 4 visits of plots have no such row and are known, with the trees "
              "that died or were cut before them, only if a table of `plots`"));
}

TEST_CASE("Plots without living trees have the area of every plot") {
  const CheckedInventory trees = measured(
      "plot,tree,year,dbh,status\n1,1,2000,20,alive\n1,1,2005,22,alive\n"
      "2,1,2000,,dead\n2,1,2005,,dead\n");
  const GrowthReport report = growth_report(trees.inventory, {.plot_area_m2 = 500.0});
  REQUIRE(report.plots.size() == 2);
  CHECK(value_of(report.plots[1], 0, GrowthPart::kStart) == 0.0);
  // One tree on 500 m2 is 20 per ha; with the empty plot 10.
  CHECK(estimate_in(report.strata.back(), 0, GrowthPart::kStart).per_ha == Approx(10.0));
}

TEST_CASE("Parts of one visit are not times of their own") {
  const auto growth_of = [](const std::string& rows) {
    return growth_report(measured("plot,tree,date,dbh\n" + rows).inventory,
                         {.plot_area_m2 = 500.0});
  };
  const std::string start = "1,1,2000-06-01,20\n1,2,2000-06-01,30\n1,3,2000-06-01,25\n";
  const std::string end = "1,1,2005-06-01,22\n1,2,2005-06-01,32\n1,3,2005-06-01,27\n";
  CHECK_NOTHROW(growth_of(start + end));
  // A tree measured again after two weeks, and a campaign of two years.
  CHECK_THROWS_WITH(
      growth_of(start + "1,1,2000-06-15,20.1\n" + end),
      Contains("2000-06-15 after 2000-06-01 seems to be no visit of its own: 1 of 3 trees"));
  // A tree measured on the next day is of the visit: 4 trees on 500 m2 are 80 / ha.
  const PlotGrowth next_day =
      growth_of(start + "1,4,2000-06-02,18\n" + end + "1,4,2005-06-01,19\n").plots.at(0);
  CHECK(value_of(next_day, 0, GrowthPart::kStart) == Approx(80.0).epsilon(1e-13));
  CHECK(value_of(next_day, 0, GrowthPart::kIngrowth) == 0.0);
  CHECK_THROWS_WITH(
      growth_of(start + "1,4,2001-06-01,18\n" + end + "1,4,2005-06-01,19\n"),
      Contains("0 of 3 trees that live before and after have a row, and others are new"));
  // A year in some rows and a date in others of one visit is one time.
  const GrowthReport mixed = growth_of(start + "1,1,2005-06-01,22\n1,2,2005,32\n1,3,2005,27\n");
  CHECK(mixed.plots.size() == 1);
  CHECK(mixed.plots.front().years == Approx(1826 / 365.25).epsilon(1e-12));
  // Some trees measured once more, and none that is new: the others are interpolated.
  const GrowthReport between = growth_of(start + "1,1,2002-06-01,21\n" + end);
  CHECK(between.plots.front().values.front()[1] == Approx(60.0));
}

TEST_CASE("A tree that was missed and is dead later died") {
  const GrowthReport report =
      growth_report(measured("plot,tree,year,dbh,status\n1,1,2000,20,alive\n1,2,2000,30,alive\n"
                             "1,1,2005,21,alive\n1,1,2010,22,alive\n1,2,2010,31,dead\n")
                        .inventory,
                    {.plot_area_m2 = 500.0});
  const auto fates = [&report](const std::string& tree) {
    std::vector<TreeFate> found;
    for (const TreeGrowth& one : report.trees) {
      if (one.tree == tree) found.push_back(one.fate);
    }
    return found;
  };
  CHECK(fates("1") == std::vector{TreeFate::kSurvivor, TreeFate::kSurvivor});
  CHECK(fates("2") == std::vector{TreeFate::kMortality});
}

TEST_CASE("A column of stems that change between visits does not tell stems apart") {
  // As classes of quality, or written in several ways.
  for (const char* const rows :
       {"1,1,a,2000,30\n1,2,b,2000,20\n1,1,b,2005,33\n1,2,b,2005,22\n",
        "1,1,1,2000,30\n1,2,1,2000,20\n1,1,1.0,2005,33\n1,2,01,2005,22\n"}) {
    const GrowthReport report =
        growth_report(measured("plot,tree,stem,year,dbh\n" + std::string(rows)).inventory,
                      {.plot_area_m2 = 500.0});
    REQUIRE(report.trees.size() == 2);
    CHECK(report.trees[0].fate == TreeFate::kSurvivor);
  }
}

TEST_CASE("Trees stand where they were first seen, and plots with a window may be empty") {
  // Plot 1: two trees inside, one 0.2 m outside at the second time; plot 2: no tree at any time.
  const CheckedInventory trees = measured(
      "plot,tree,x,y,year,dbh\n1,1,5,5,2000,20\n1,2,9.9,5,2000,20\n1,3,12,5,2000,20\n"
      "1,1,,,2005,22\n1,2,10.1,5,2005,22\n1,3,12,5,2005,22\n");
  StandReportOptions options;
  const auto square = [](double x) { return Window::rectangle({x, 0}, {x + 10.0, 10.0}); };
  options.units.windows = {{.plot = "1", .window = square(0)}, {.plot = "2", .window = square(20)}};
  const GrowthReport report = growth_report(trees.inventory, options);
  REQUIRE(report.plots.size() == 2);
  CHECK(report.plots[0].values[0][0] == Approx(200.0));
  CHECK(report.plots[0].values[0][1] == Approx(200.0));
  CHECK(report.plots[1].values[0][1] == 0.0);
  CHECK(report.strata.back().plots == 2);
  CHECK(tells(report.notes, "2 rows of living trees are outside of the window of the plot"));
}

TEST_CASE("Years and dates of measurements") {
  CHECK(years_of("2019") == 2019.0);
  // A day is 1/365.25 of a year; from 2019-01-01 to 2024-01-01 are 1826 days.
  CHECK(*years_of("2024-01-01") - *years_of("2019-01-01") == Approx(1826 / 365.25).epsilon(1e-12));
  CHECK(years_of("30.06.2019") == years_of("2019-06-30"));
  CHECK(years_of("2019/06/30") == years_of("2019-06-30T12:00:00"));
  for (const char* const date : {"2019-JUN-30", "30-Jun-2019", "30 June 2019", "30.june.2019"}) {
    CHECK(years_of(date) == years_of("2019-06-30"));
  }
  CHECK(years_of("05-OCT-2019 10:00") == years_of("2019-10-05"));
  CHECK(!years_of("2019-JUX-30"));
  CHECK(!years_of("2019-ANF-30"));
  CHECK(!years_of("2019-02-30"));
  CHECK(!years_of("spring"));
  CHECK(!years_of("12"));
}

TEST_CASE("Growth without two times, or with text for them, is an error") {
  CHECK_THROWS_WITH(growth_report(measured("plot,tree,dbh\n1,1,20\n").inventory, {}),
                    Contains("`columns=year=COLUMN`"));
  CHECK_THROWS_WITH(growth_report(measured("plot,tree,year,dbh\n1,1,2010,20\n").inventory, {}),
                    Contains("no plot was measured twice"));
  CHECK_THROWS_WITH(
      growth_report(measured("plot,tree,year,dbh\n1,1,2010,20\n1,1,now,21\n").inventory, {}),
      Contains("growth.csv:3: year: 'now' is not a year or date"));
}

TEST_CASE("A survivor without a second diameter is left out of both sums and named") {
  const CheckedInventory checked = measured(
      "plot,tree,species,year,dbh\n1,1,A,2010,20\n1,2,A,2010,30\n1,3,A,2010,40\n"
      "1,1,A,2015,22\n1,2,A,2015,33\n1,3,A,2015,\n");
  StandReportOptions options;
  options.plot_area_m2 = 500.0;
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.plots.size() == 1);
  const PlotGrowth& plot = report.plots[0];
  // pi / 4 (d2^2 - d1^2) of the two trees, 20 plots per hectare, 5 years.
  const double growth = M_PI / 4e4 * ((484.0 - 400.0) + (1089.0 - 900.0)) * 20.0 / 5.0;
  CHECK(value_of(plot, 1, GrowthPart::kSurvivorGrowth) == Approx(growth).epsilon(1e-12));
  CHECK(value_of(plot, 1, GrowthPart::kNetChange) == Approx(growth).epsilon(1e-12));
  CHECK(value_of(plot, 1, GrowthPart::kFactorChange) == 0.0);
  // The three stems are known.
  CHECK(value_of(plot, 0, GrowthPart::kStart) == Approx(60.0).epsilon(1e-12));
  CHECK(value_of(plot, 0, GrowthPart::kEnd) == Approx(60.0).epsilon(1e-12));
  check_balance(plot);
  CHECK(tells(report.notes,
              "left out of both sums of basal_area_m2: 'plot 1, tree 3 (2010 to 2015)'"));
}

TEST_CASE("A survivor that stands elsewhere may be another tree") {
  const auto moved = [](double x) {
    return measured(
        "plot,tree,species,x,y,year,dbh\n"
        "1,1,A,0,0,2010,20\n1,2,A,4,0,2010,10\n1,3,A,4,6,2010,30\n"
        "1,1,A,0.3,0,2015,22\n1,2,A," +
        std::to_string(x) + ",0,2015,12\n1,3,A,4,6,2015,33\n");
  };
  const std::string note =
      "1 tree stands farther from the earlier position than the nearest neighbor did, at most 11 "
      "m: "
      "plot 1 (2015), tree 2";
  CHECK(tells(growth_report(moved(15.0).inventory, {}).notes, note));
  // Its nearest neighbor stood at 4 m.
  CHECK_FALSE(tells(growth_report(moved(7.9).inventory, {}).notes, "nearest neighbor"));
}

TEST_CASE("Days of one visit are joined, and trees that are numbered anew are refused") {
  // The same four trees, the first two measured on 3 May, the others on 4 May.
  const auto rows = [](const char* first, const char* second, int add) {
    std::string text;
    for (int tree = 1; tree <= 4; ++tree) {
      text += "1," + std::to_string(tree + add) + ",A," + (tree < 3 ? first : second) + "," +
              std::to_string(20 + tree + add / 2) + "\n";
    }
    return text;
  };
  const std::string head = "plot,tree,species,date,dbh\n";
  const auto growth = [&](const std::string& text) {
    StandReportOptions options;
    options.plot_area_m2 = 400.0;
    return growth_report(measured(head + text).inventory, options);
  };
  // Two days of three years each, by 365.25 days a year: the means are 1826 days apart, too.
  const GrowthReport joined =
      growth(rows("2010-05-03", "2010-05-04", 0) + rows("2015-05-03", "2015-05-04", 0));
  REQUIRE(joined.trees.size() == 4);
  CHECK(joined.trees.front().years == Approx(1826 / 365.25).epsilon(1e-12));
  CHECK(tells(joined.notes, "2 days on which no tree was measured twice are of the visit"));
  CHECK_THROWS_WITH(
      growth(rows("2010-05-03", "2010-05-03", 0) + rows("2015-05-03", "2015-05-03", 4)),
      Contains("trees must keep their numbers"));
  CHECK(growth(rows("2010-05-03", "2010-05-03", 0) + rows("2010-06-03", "2010-06-03", 0))
            .trees.size() == 4);
}

TEST_CASE("Growth of numbers that are other trees' later is refused") {
  const auto growth = [](const char* second) {
    return growth_report(
        measured(std::string("plot,tree,species,year,dbh\n1,1,fir,2010,20\n1,2,fir,2010,30\n"
                             "1,3,oak,2010,25\n") +
                 second)
            .inventory,
        {.plot_area_m2 = 400.0});
  };
  CHECK_THROWS_WITH(growth("1,1,oak,2015,24\n1,2,oak,2015,31\n1,3,oak,2015,26\n"),
                    Contains("2 of 3 trees are others at the end of a period"));
  CHECK_THROWS_WITH(growth("1,1,fir,2015,12\n1,2,fir,2015,90\n1,3,oak,2015,26\n"),
                    Contains("2 of 3 trees are others at the end of a period"));
  // A missing species is not another one.
  const GrowthReport report = growth("1,1,,2015,21\n1,2,,2015,31\n1,3,,2015,26\n");
  CHECK_FALSE(tells(report.notes, "another species"));
}

TEST_CASE("Codes of trees without a dbh that count as living are named") {
  InventoryOptions options;
  options.keeps_measurements = true;
  const auto notes = [&](const char* codes) {
    return read_inventory(csv_of(std::string("plot,tree,year,dbh,codes\n1,1,2010,20,M\n"
                                             "1,2,2010,30,\n1,1,2015,21,M\n1,2,2015,,") +
                                 codes + "\n"),
                          options)
        .notes;
  };
  CHECK(tells(notes("D;S"),
              "of 1 row without a dbh that count as living, 1 has D;S in column codes"));
  CHECK_FALSE(tells(notes("M"), "no tree with a dbh has"));
}

TEST_CASE("A status that is the same in all rows of a tree is that of the last visit") {
  // Of four trees on 0.1 ha, tree 2 has died: 10 / ha in 5 years.
  const auto growth = [](const std::string& text, InventoryOptions options) {
    options.keeps_measurements = true;
    return growth_report(read_inventory(csv_of(text), options).inventory, {.plot_area_m2 = 1000.0});
  };
  const auto check = [](const GrowthReport& report) {
    const PlotGrowth& plot = report.plots.at(0);
    CHECK(value_of(plot, 0, GrowthPart::kStart) == Approx(40.0).epsilon(1e-13));
    CHECK(value_of(plot, 0, GrowthPart::kEnd) == Approx(30.0).epsilon(1e-13));
    CHECK(value_of(plot, 0, GrowthPart::kMortality) == Approx(2.0).epsilon(1e-13));
  };
  const auto wide = [](const char* last) {
    return std::string("plot,tree,D_2010,D_2015,status\n1,1,20,21,alive\n1,2,20,") + last +
           ",dead\n1,3,20,21,alive\n1,4,20,22,alive\n";
  };
  const std::vector<ColumnMapping> visits{{"dbh", "D_{year}"}};
  for (const char* const last : {"", "20.5", "0", "-999"}) {
    check(growth(wide(last), {.visits = visits}));
  }
  CHECK(tells(growth(wide(""), {.visits = visits}).notes, "1 dead or cut tree was alive"));
  check(
      growth("plot,tree,year,dbh,status\n1,1,2010,20,alive\n1,2,2010,20,dead\n"
             "1,3,2010,20,alive\n1,4,2010,20,alive\n1,1,2015,21,alive\n1,3,2015,21,alive\n"
             "1,4,2015,22,alive\n",
             {}));
  // A status of each visit is that of the visit.
  const GrowthReport own =
      growth("plot,tree,D_2010,D_2015,S_2010,S_2015\n1,1,20,21,alive,alive\n1,2,20,20,dead,dead\n",
             {.visits = {{"dbh", "D_{year}"}, {"status", "S_{year}"}}});
  CHECK(value_of(own.plots.at(0), 0, GrowthPart::kMortality) == 0.0);
  CHECK(value_of(own.plots.at(0), 0, GrowthPart::kStart) == Approx(10.0).epsilon(1e-13));
}

TEST_CASE("Plots without trees and without a time are empty at all times") {
  const CheckedInventory checked =
      measured("plot,tree,year,dbh\n1,1,2010,20\n1,1,2015,22\n2,1,2010,20\n2,1,2015,22\n");
  StandReportOptions options;
  options.design.plots =
      read_plot_table(csv_of("plot,area\n1,400\n2,400\n3,400\n4,400\n", "plots.csv"));
  const GrowthReport report = growth_report(checked.inventory, options);
  REQUIRE(report.plots.size() == 4);
  // 2 trees on 4 plots of 0.04 ha.
  const StratumGrowth& all = report.strata.back();
  CHECK(all.plots == 4);
  CHECK(estimate_in(all, 0, GrowthPart::kStart).per_ha == Approx(12.5).epsilon(1e-13));
  const CheckedInventory panels = measured(
      "plot,tree,year,dbh\n1,1,2010,20\n1,1,2015,22\n2,1,2012,20\n2,1,2017,22\n"
      "1,1,2020,24\n");
  CHECK_THROWS_WITH(growth_report(panels.inventory, options),
                    Contains("plots.csv: plots without trees and without a time"));
}

TEST_CASE("Windows need positions") {
  const CheckedInventory trees = measured(
      "plot,tree,species,year,dbh,h\n1,1,A,2000,20,\n"
      "1,1,A,2005,22,\n");
  StandReportOptions options;
  options.units.windows = {{kEveryPlot, Window::circle({0, 0}, 10.0)}};
  CHECK_THROWS_WITH(growth_report(trees.inventory, options),
                    Contains("windows need the positions of trees"));
}

TEST_CASE("A plot whose trees have new numbers is refused, and one with new trees is not") {
  const auto growth = [](int number, int dbh) {
    std::string text = "plot,tree,year,dbh\n2,1,2010,20\n2,1,2015,22\n";
    for (int tree = 1; tree <= 3; ++tree) {
      text += "1," + std::to_string(tree) + ",2010,30\n";
      text += "1," + std::to_string(tree + number) + ",2015," + std::to_string(dbh) + "\n";
    }
    return growth_report(measured(text).inventory, {.plot_area_m2 = 1000.0});
  };
  CHECK_THROWS_WITH(
      growth(100, 32),
      Contains("no tree comes again in 1 period of a plot") && Contains("plot 1 (2010 to 2015)"));
  CHECK_NOTHROW(growth(0, 32));
  // Planted after a clear-cut.
  CHECK_NOTHROW(growth(100, 8));
}

TEST_CASE("Dates with the year last are read if a number of the column shows the day") {
  const auto growth = [](const std::string& first, const std::string& second) {
    const std::string rows = "1,1,20," + first + "\n1,1,22," + second + "\n";
    return growth_report(measured("plot,tree,dbh,fecha\n" + rows).inventory,
                         {.plot_area_m2 = 400.0});
  };
  // From 2010-05-13 to 2015-06-01 are 1845 days.
  for (const auto& [first, second] : std::vector<std::pair<std::string, std::string>>{
           {"13/05/2010", "1/6/2015"}, {"05/13/2010", "6/1/2015"}, {"13-05-2010", "01-06-2015"}}) {
    const GrowthReport report = growth(first, second);
    CHECK(report.plots[0].years == Approx(1845 / 365.25).epsilon(1e-12));
    CHECK(report.plots[0].from == "2010-05-13");
    CHECK(tells(report.notes, "dates such as " + first + " are read as"));
  }
  CHECK(growth("05/2010", "05/2015").plots[0].years == Approx(1826 / 365.25).epsilon(1e-12));
  const GrowthReport unknown = growth("05/06/2010", "07/06/2015");
  CHECK(unknown.plots[0].years == 5.0);
  CHECK(tells(unknown.notes, "only their years are used"));
  CHECK_THROWS_WITH(growth("05/06/2010", "11/06/2010"),
                    Contains("growth.csv:3: fecha: '11/06/2010' may be day/month/year"));
  CHECK_THROWS_WITH(growth("31/02/2010", "1/6/2015"), Contains("fecha: '31/02/2010' is not"));
}
