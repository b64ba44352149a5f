// SPDX-License-Identifier: MIT
#include "silvafit/data/table.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"

using silvafit::data::kMissing;
using silvafit::data::Table;
using silvafit::data::TextColumn;

namespace {

TextColumn text_of(std::initializer_list<const char*> values) {
  TextColumn column;
  for (const char* value : values) column.append(value);
  return column;
}

}  // namespace

TEST_CASE("a table keeps columns in order and replaces them by name") {
  Table table;
  table.set("dbh", {10.0, 20.5});
  table.set("species", text_of({"SM", "杉木"}));
  CHECK(table.rows() == 2);
  CHECK(table.names() == std::vector<std::string>{"dbh", "species"});
  CHECK(table.is_numeric("dbh"));
  CHECK(table.text("species")[1] == "杉木");

  table.set("species", {1.0, 2.0});
  CHECK(table.is_numeric("species"));
  CHECK(table.names().size() == 2);
  CHECK_THROWS_AS(table.set("h", {1.0}), silvafit::UsageError);
}

TEST_CASE("asking for a column that is not there names those that are") {
  Table table;
  table.set("dbh", {1.0});
  CHECK_THROWS_WITH(table.numbers("h"),
                    Catch::Matchers::Contains("'h'") && Catch::Matchers::Contains("dbh"));
  CHECK_THROWS_AS(table.text("dbh"), silvafit::UsageError);
}

TEST_CASE("labels spell numbers as short as they read back") {
  Table table;
  table.set("plot", {1.0, 0.1, kMissing});
  const TextColumn labels = table.labels("plot");
  CHECK(labels[0] == "1");
  CHECK(labels[1] == "0.1");
  CHECK(labels.is_missing(2));
}

TEST_CASE("selected rows keep their lines") {
  Table table;
  table.set("x", {1.0, 2.0, 3.0});
  table.set("s", text_of({"a", "b", "a"}));
  table.set_origin("t.csv", {2, 3, 5});
  const std::vector<std::size_t> rows{2, 0};
  const Table part = table.select(rows);
  CHECK(part.numbers("x")[0] == 3.0);
  CHECK(part.text("s")[0] == "a");
  CHECK(part.line(0) == 5);
  CHECK(part.file() == "t.csv");
}

TEST_CASE("whole numbers are labels without an exponent") {
  Table table;
  table.set("plot", std::vector<double>{100000.0, 100001.0, -2e6, 1.5, 9007199254740992.0, 1e300});
  const TextColumn labels = table.labels("plot");
  CHECK(labels[0] == "100000");
  CHECK(labels[1] == "100001");
  CHECK(labels[2] == "-2000000");
  CHECK(labels[3] == "1.5");
  CHECK(labels[4] == "9007199254740992");
  CHECK(labels[5] == "1e+300");
}
