// SPDX-License-Identifier: MIT
// Rows of other sources than CSV files: sheets as text, tables in memory, and layers.
#include <catch2/catch.hpp>
#include <memory>

#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

TableSource sheet(std::string text) {
  return std::make_shared<const TableText>(
      TableText{.name = "a.xlsx (sheet Trees)", .text = std::move(text), .separator = ';'});
}

std::shared_ptr<const Table> texts() {
  Table table(3);
  TextColumn numbers;
  for (const char* const value : {"1.50", "2", "30"}) numbers.append(value);
  TextColumn mixed;
  for (const char* const value : {"07", "8", "x"}) mixed.append(value);
  table.set("dbh", std::move(numbers));
  table.set("plot", std::move(mixed));
  table.set_origin("a.gpkg", {});
  return std::make_shared<const Table>(std::move(table));
}

TEST_CASE("line n of a sheet's text is its row n, with any rows above the header") {
  CsvReader reader(sheet("Forest;;\n\nplot;dbh;h\n1;20,5;\"a;b\"\n\n2;30;c\n"));
  CHECK(reader.file() == "a.xlsx (sheet Trees)");
  CHECK(reader.header() == std::vector<std::string>{"plot", "dbh", "h"});
  CHECK(reader.layout().header_line == 3);
  std::vector<std::string_view> fields;
  REQUIRE(reader.next(fields));
  CHECK(reader.line() == 4);
  CHECK(fields[2] == "a;b");
  double dbh = 0.0;
  REQUIRE(reader.parse_number(fields[1], dbh));
  CHECK(dbh == 20.5);
  REQUIRE(reader.next(fields));
  CHECK(reader.line() == 6);
  CHECK_FALSE(reader.next(fields));
}

TEST_CASE("a column of a sheet that turns out to be text keeps the spelling of its numbers") {
  const Table table = read_csv_table(sheet("plot;dbh\n1.0;20\n007;21\nA;22\n"));
  const TextColumn& plot = table.text("plot");
  CHECK(plot[0] == "1.0");
  CHECK(plot[1] == "007");
  CHECK(table.numbers("dbh")[2] == 22.0);
  CHECK(table.line(2) == 4);
}

TEST_CASE("texts of a layer that are all numbers become numbers, those of a table do not") {
  const Table of_layer = read_csv_table(LayerTable{texts()});
  REQUIRE(of_layer.is_numeric("dbh"));
  CHECK(of_layer.numbers("dbh")[0] == 1.5);
  CHECK(of_layer.text("plot")[0] == "07");
  CHECK(of_layer.file() == "a.gpkg");
  const Table of_memory = read_csv_table(texts());
  CHECK_FALSE(of_memory.is_numeric("dbh"));
}

}  // namespace
}  // namespace silvafit::data
