// SPDX-License-Identifier: MIT
#include "workflow/repeated_rows.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "silvafit/study/tree_table.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

data::TextColumn column_of(const std::vector<std::string>& texts) {
  data::TextColumn column;
  for (const std::string& text : texts) {
    text.empty() ? column.append_missing() : column.append(text);
  }
  return column;
}

data::Table table_of(const std::vector<std::string>& plot,
                     const std::vector<std::string>& tree,
                     const std::vector<double>& h) {
  data::Table table;
  table.set("plot", column_of(plot));
  table.set("tree", column_of(tree));
  table.set("h", h);
  return table;
}

}  // namespace

TEST_CASE("rows with all values of an earlier row of the same plot and tree are copies") {
  const double missing = data::kMissing;
  ObservedTable rows;
  rows.table = table_of({"1", "1", "2", "1", "1", "1", "", ""},
                        {"a", "a", "a", "a", "b", "b", "a", "a"},
                        {5.0, 6.0, 5.0, 5.0, missing, missing, 5.0, 5.0});
  RepeatCounts counts;
  find_copies("plot", "tree", rows, counts);
  // Rows without a plot cannot be assigned to a tree.
  CHECK(rows.distinct == std::vector<std::size_t>{0, 1, 2, 4, 6, 7});
  CHECK(rows.place == std::vector<std::size_t>{0, 1, 2, 0, 3, 3, 4, 5});
  CHECK(of_all_rows(std::vector<int>{10, 11, 12, 13, 14, 15}, rows.place) ==
        std::vector<int>{10, 11, 12, 10, 13, 13, 14, 15});
  REQUIRE(counts.notes().size() == 2);
  CHECK(counts.notes()[0] ==
        "2 rows are copies of an earlier row of the same plot and tree and used once, the first: "
        "copy of an earlier row (plot 1, tree a)");
  CHECK(counts.notes()[1] ==
        "1 row has the plot and tree of another row with other values; each is an observation");
}

TEST_CASE("the copies are those found by comparing all pairs") {
  std::mt19937 bits(5);
  std::vector<std::string> plot;
  std::vector<std::string> tree;
  std::vector<double> h;
  for (int i = 0; i < 400; ++i) {
    plot.push_back(std::to_string(bits() % 4));
    tree.push_back(std::to_string(bits() % 10));
    h.push_back(bits() % 5 == 0 ? data::kMissing : static_cast<double>(bits() % 4));
  }
  ObservedTable rows;
  rows.table = table_of(plot, tree, h);
  RepeatCounts counts;
  find_copies("plot", "tree", rows, counts);
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < h.size(); ++i) {
    bool is_copy = false;
    for (std::size_t j = 0; j < i; ++j) {
      const bool same_h = h[i] == h[j] || (std::isnan(h[i]) && std::isnan(h[j]));
      is_copy = is_copy || (plot[i] == plot[j] && tree[i] == tree[j] && same_h);
    }
    if (!is_copy) expected.push_back(i);
  }
  CHECK(rows.distinct == expected);
}

TEST_CASE("trees keep one row each, other trees of one number get a new one") {
  data::Table table = table_of(
      {"1", "1", "1", "2", "1"}, {"a", "a", "a", "a", "b"}, {20.0, 21.0, 20.0, 20.0, 20.0});
  const auto measure = [&table](const std::string& name) {
    if (!table.has(name)) return std::vector<double>();
    const auto values = table.numbers(name);
    return std::vector<double>(values.begin(), values.end());
  };
  RepeatedTreeCounts counts;
  keep_one_row_per_tree(table, "plot", "tree", std::nullopt, measure, true, counts);
  const auto notes = counts.notes();
  REQUIRE(table.rows() == 4);
  const data::TextColumn tree = table.labels("tree");
  CHECK(tree[0] == "a");
  CHECK(tree[1] == "a#2");
  CHECK(tree[2] == "a");
  CHECK(tree[3] == "b");
  REQUIRE(notes.size() == 2);
  CHECK(notes[0] ==
        "1 row repeats a tree and is skipped, the first: the same tree is in an earlier row (plot "
        "1, tree a)");
  CHECK(notes[1] ==
        "1 tree has the number of another tree of the same plot and got a new one, the first: now "
        "a#2 (plot 1, tree a)");
}

TEST_CASE("a column of ours may be one field of a file, or several that are joined") {
  const std::vector<std::string> header{"site", "sub", "BHD", "tree"};
  const auto found = [&](const std::string& name, const std::vector<std::string>& columns) {
    return stand::fields_of(name, header, stand::parse_column_mappings(columns), "trees.csv");
  };
  CHECK(found("plot", {"plot=sub"}) == std::vector<std::size_t>{1});
  CHECK(found("plot", {"plot=site+sub"}) == std::vector<std::size_t>{0, 1});
  CHECK(found("dbh", {}) == std::vector<std::size_t>{2});
  CHECK(found("tree", {}) == std::vector<std::size_t>{3});
  CHECK(found("plot", {}).empty());
}
