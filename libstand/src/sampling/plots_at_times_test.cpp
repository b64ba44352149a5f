// SPDX-License-Identifier: MIT
#include "silvafit/stand/plots_at_times.hpp"

#include <catch2/catch.hpp>
#include <memory>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::stand;
using Catch::Matchers::Contains;

namespace {

CheckedInventory read(const std::string& text) {
  return read_inventory(std::make_shared<const data::TableText>(data::TableText{
                            .name = "repeated.csv", .text = text, .separator = ','}),
                        {.period = "when"});
}

std::vector<std::string> names_of(const std::vector<NamedWindow>& windows) {
  std::vector<std::string> names;
  for (const NamedWindow& window : windows) names.push_back(window.plot.value_or("stand"));
  return names;
}

const Window kCircle = Window::circle({0, 0}, 10);

}  // namespace

TEST_CASE("with periods each plot and time is a plot, and a tree has a row in each") {
  const CheckedInventory read_twice = read(
      "plot,tree,when,dbh,status\n7,1,2010,20,alive\n7,2,2010,30,alive\n7,1,2020,24,alive\n"
      "7,2,2020,33,dead\n8,1,2020,18,alive\n8,2,,18,alive\n8,1,2020,18,alive\n");
  const Inventory& inventory = read_twice.inventory;
  REQUIRE(inventory.size() == 4);
  CHECK(inventory.plot.levels() == std::vector<std::string>{"7 (2010)", "7 (2020)", "8 (2020)"});
  CHECK(inventory.measured_plot[2] == "7");
  CHECK(inventory.time[2] == "2020");
  // A dead tree, a row without a time, and a copy at the same time.
  REQUIRE(read_twice.excluded.size() == 3);
  CHECK(read_twice.excluded[0].reason == "the tree is dead");
  CHECK(read_twice.excluded[1].reason == "the time of measurement is missing");
  CHECK_THAT(read_twice.excluded[2].reason, Contains("the same tree"));
  const std::vector<PlotAtTime> plots = plots_at_times(inventory);
  REQUIRE(plots.size() == 3);
  CHECK(plots[1].plot == "7");
  CHECK(plots[1].time == "2020");
  CHECK_THROWS_WITH(read("plot,tree,dbh\n1,1,20\n"), Contains("unknown column 'when'"));
}

TEST_CASE("windows of plots hold for all of their times") {
  const std::vector<PlotAtTime> plots{{"7", "2010"}, {"7", "2020"}, {"8", "2020"}};
  CHECK(names_of(windows_at_times({{.plot = "7", .window = kCircle}}, plots)) ==
        std::vector<std::string>{"7 (2010)", "7 (2020)"});
  CHECK(names_of(windows_at_times({{.plot = kEveryPlot, .window = kCircle}}, plots)) ==
        std::vector<std::string>{"*"});
  CHECK(names_of(windows_at_times({{.window = kCircle}}, {{"8", "2010"}, {"8", "2020"}})) ==
        std::vector<std::string>{"8 (2010)", "8 (2020)"});
  CHECK_THROWS_WITH(windows_at_times({{.window = kCircle}}, plots), Contains("2 plots"));
}

TEST_CASE("rows of a table of plots belong to the measurements of their time") {
  SamplingDesign design;
  design.plots.emplace();
  design.plots->plots = {{.plot = "7", .time = "30.06.2010", .area_m2 = 100.0},
                         {.plot = "7", .time = "2020", .area_m2 = 400.0},
                         {.plot = "7", .time = "2030", .area_m2 = 500.0},
                         {.plot = "8", .area_m2 = 200.0},
                         {.plot = "9", .area_m2 = 300.0}};
  const SamplingDesign at_times =
      design_at_times(design, {{"7", "2010"}, {"7", "2020"}, {"8", "2010"}, {"8", "2020"}});
  std::vector<std::string> labels;
  for (const PlotRecord& record : at_times.plots->plots) labels.push_back(record.plot);
  // Plot 7 in 2030 and plot 9 have no trees: they are empty plots.
  CHECK(labels ==
        std::vector<std::string>{"7 (2010)", "7 (2020)", "7 (2030)", "8 (2010)", "8 (2020)", "9"});
  CHECK(at_times.plots->plots[0].area_m2 == 100.0);
}
