// SPDX-License-Identifier: MIT
#include "silvafit/data/list_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

using namespace silvafit::data;

TEST_CASE("a list becomes a table by members and functions") {
  struct Plot {
    std::string name{};
    double area_m2 = 0.0;
    std::size_t trees = 0;
    bool is_cut = false;
  };
  const std::vector<Plot> plots{{"07", 400.0, 12, true}, {"7", kMissing, 0, false}};
  ListTable<Plot> made(plots);
  made.add("plot", &Plot::name);
  made.add("area", &Plot::area_m2);
  made.add("trees", &Plot::trees);
  made.add("cut", &Plot::is_cut);
  made.add("label", [](const Plot& plot) { return "plot " + plot.name; });
  const Table table = std::move(made).table();
  CHECK(table.names() == std::vector<std::string>{"plot", "area", "trees", "cut", "label"});
  CHECK(table.text("plot")[0] == "07");
  CHECK(table.text("plot")[1] == "7");
  CHECK(table.numbers("area")[0] == 400.0);
  CHECK(std::isnan(table.numbers("area")[1]));
  CHECK(table.numbers("trees")[0] == 12.0);
  CHECK(table.numbers("cut")[0] == 1.0);
  CHECK(table.text("label")[1] == "plot 7");
  const std::vector<Plot> none;
  CHECK(std::move(ListTable<Plot>(none)).table().rows() == 0);
}
