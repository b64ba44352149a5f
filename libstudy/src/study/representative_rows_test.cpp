// SPDX-License-Identifier: MIT
// Samples of large tables: shares of the plots, and the range of DBH within them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "study/study_work.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

/// Plots of given sizes, with DBH 1, 2, 3 ... in each.
data::Table plots_of(const std::vector<std::size_t>& sizes) {
  data::TextColumn plots;
  std::vector<double> dbh;
  for (std::size_t plot = 0; plot < sizes.size(); ++plot) {
    for (std::size_t tree = 1; tree <= sizes[plot]; ++tree) {
      plots.append(std::to_string(plot));
      dbh.push_back(static_cast<double>(tree));
    }
  }
  data::Table table;
  table.set("plot", std::move(plots));
  table.set("dbh", std::move(dbh));
  return table;
}

std::map<std::string, std::vector<double>> by_plot(const data::Table& table,
                                                   const std::vector<std::size_t>& rows) {
  std::map<std::string, std::vector<double>> result;
  for (const std::size_t row : rows) {
    result[std::string(table.text("plot")[row])].push_back(table.numbers("dbh")[row]);
  }
  return result;
}

}  // namespace

TEST_CASE("large plots have the same share, spread over their range of DBH") {
  const data::Table table = plots_of({1000, 500});
  const auto rows = representative_rows(table, "plot", 200);
  REQUIRE(rows.size() == 200);
  CHECK(std::ranges::is_sorted(rows));
  const auto taken = by_plot(table, rows);
  REQUIRE(taken.at("0").size() == 100);
  // The middles of 100 parts of ten trees each: 6, 16, 26 ... 996.
  for (std::size_t k = 0; k < 100; ++k)
    CHECK(taken.at("0")[k] == 6.0 + 10.0 * static_cast<double>(k));
  CHECK(taken.at("1").size() == 100);
}

TEST_CASE("of many small plots some are selected completely") {
  const data::Table table = plots_of(std::vector<std::size_t>(100, 10));
  const auto taken = by_plot(table, representative_rows(table, "plot", 200));
  CHECK(taken.size() == 20);
  for (const auto& [plot, dbh] : taken) CHECK(dbh.size() == 10);
}

TEST_CASE("at least 40 trees are selected of larger plots") {
  const data::Table table = plots_of(std::vector<std::size_t>(50, 100));
  const auto taken = by_plot(table, representative_rows(table, "plot", 400));
  CHECK(taken.size() == 10);
  for (const auto& [plot, dbh] : taken) CHECK(dbh.size() == 40);
}
