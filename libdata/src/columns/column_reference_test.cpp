// SPDX-License-Identifier: MIT
#include "silvafit/data/column_reference.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"

using Catch::Matchers::Contains;
using namespace silvafit;
using namespace silvafit::data;

namespace {

const std::vector<std::string> kNames{"plot", "BHD [cm]", "H.m", "a-b", "a", "b", "2021"};

TextColumn texts(const std::vector<std::string>& values) {
  TextColumn column;
  for (const std::string& value : values)
    value.empty() ? column.append_missing() : column.append(value);
  return column;
}

/// Three trees; the height of the last is a word.
Table three_trees() {
  Table table(3);
  table.set("unit", texts({"m", "dm", "m"}));
  table.set("h", texts({"15.5", "", "tall"}));
  table.set("BHD [mm]", std::vector<double>{205.0, 180.0, 90.0});
  return table;
}

}  // namespace

TEST_CASE("a text that equals a column's name is that column, with any signs") {
  for (const char* name : {"BHD [cm]", "H.m", "a-b", "2021"}) {
    const ColumnReference reference = column_reference("dbh", name, kNames);
    CHECK(reference.text == name);
    CHECK_FALSE(reference.expression);
  }
}

TEST_CASE("any other text is an expression, in which such names have backquotes") {
  const ColumnReference reference = column_reference("dbh", "`BHD [cm]`/10 + a", kNames);
  REQUIRE(reference.expression);
  CHECK(reference.expression->variables() == std::vector<std::string>{"BHD [cm]", "a"});
  CHECK(column_reference("dbh", "a - b", kNames).expression);
  CHECK(column_reference("dbh", "ifelse(plot == \"x\", a, b)", kNames).expression);
}

TEST_CASE("other texts are refused with the remedy") {
  CHECK_THROWS_AS(column_reference("dbh", "BHD [cm]/10", kNames), FormulaError);
  CHECK_THROWS_WITH(column_reference("dbh", "BHD [cm]/10", kNames),
                    Contains("unexpected '['") && Contains("write `BHD [cm]`, in backquotes"));
  CHECK_THROWS_WITH(column_reference("dbh", "BHD [mm]", kNames),
                    Contains("unknown column 'BHD [mm]'; available: plot, BHD [cm]"));
  CHECK_THROWS_WITH(column_reference("dbh", "c/10", kNames, "trees.csv"),
                    Contains("trees.csv: unknown column 'c' in dbh=c/10; available:"));
  CHECK_THROWS_AS(column_reference("h", "ifelse(site == \"x\", a, b)", kNames), InputError);
}

TEST_CASE("cells with text cost their rows only") {
  const Table table = three_trees();
  std::vector<TextCell> cells;
  const std::vector<double> h = numbers_of(table, "h", cells);
  CHECK(h[0] == 15.5);
  CHECK(std::isnan(h[1]));
  CHECK(std::isnan(h[2]));
  REQUIRE(cells.size() == 1);
  CHECK(cells[0].row == 2);
  CHECK(cells[0].column == "h");
  CHECK(cells[0].text == "tall");
  CHECK_THROWS_AS(numbers_of(table, "cw", cells), UsageError);
}

TEST_CASE("expressions read columns with some text, and compare text") {
  const Table table = three_trees();
  std::vector<TextCell> cells;
  const auto values = [&](const char* text) {
    return numbers_of(table, column_reference("x", text, table.names()), cells);
  };
  CHECK(values("`BHD [mm]`/10") == std::vector<double>{20.5, 18.0, 9.0});
  CHECK(cells.empty());
  CHECK(values("ifelse(unit == \"dm\", 10, 1)") == std::vector<double>{1.0, 10.0, 1.0});
  CHECK(values("h*10")[0] == 155.0);
  REQUIRE(cells.size() == 1);
  CHECK(cells[0].row == 2);
  CHECK_THROWS_WITH(values("ifelse(h == \"tall\", 30, h)"),
                    Contains("'h' is used as a number and as text"));
}

TEST_CASE("the columns of a reference are its own, or each that its expression reads once") {
  CHECK(column_reference("dbh", "BHD [cm]", kNames).columns() ==
        std::vector<std::string>{"BHD [cm]"});
  std::vector<std::string> columns =
      column_reference("h", "a*b + ifelse(plot == \"7\", a, 2)", kNames).columns();
  std::ranges::sort(columns);
  CHECK(columns == std::vector<std::string>{"a", "b", "plot"});
}
