// SPDX-License-Identifier: MIT
#include "silvafit/data/checked_columns.hpp"

#include <catch2/catch.hpp>

#include "silvafit/data/csv.hpp"

using namespace silvafit;
using namespace silvafit::data;

using Catch::Matchers::Contains;

namespace {

Table trees_to_check() {
  Table table;
  TextColumn plot;
  TextColumn species;
  for (const char* text : {"07", "07", "08", "08"}) plot.append(text);
  for (const char* text : {"SM", "BHN", "SM", "SM"}) species.append(text);
  table.set("plot", plot);
  table.set("tree", std::vector<double>{1.0, 2.0, 3.0, 4.0});
  table.set("species", species);
  table.set("dbh", std::vector<double>{10.0, 20.0, -3.0, kMissing});
  table.set("h", std::vector<double>{8.0, 15.0, 9.0, 10.0});
  table.set_origin("trees.csv", {2, 3, 4, 5});
  return table;
}

}  // namespace

TEST_CASE("a condition selects rows, and is false if its values are missing") {
  CHECK(rows_where("species == \"SM\"", trees_to_check()).rows() == 3);
  CHECK(rows_where("species == \"SM\" && dbh > 0", trees_to_check()).rows() == 1);
  // The missing dbh is neither below nor not below 15.
  CHECK(rows_where("dbh != 10", trees_to_check()).rows() == 2);
  CHECK(rows_where("!(dbh < 15)", trees_to_check()).rows() == 1);
  CHECK(rows_where("dbh < 15 || plot == \"08\"", trees_to_check()).rows() == 3);
  CHECK_THROWS_WITH(rows_where("tree", trees_to_check()),
                    Contains("tree is 2 here, and no condition, which is true or false"));
  CHECK_THROWS_WITH(rows_where("dbh == 10 || 15", trees_to_check()),
                    Contains("a number is no condition"));
  CHECK_THROWS_WITH(rows_where("dbh > 1 && 15", trees_to_check()),
                    Contains("a number is no condition"));
  CHECK_THROWS_WITH(rows_where("dbh > 99", trees_to_check()),
                    Contains("trees.csv: no row satisfies"));
  CHECK_THROWS_WITH(rows_where("species == SM", trees_to_check()),
                    Contains("column 12: unknown column 'SM' (put text in double quotes)"));
  CHECK_THROWS_WITH(rows_where("species > 1", trees_to_check()),
                    Contains("trees.csv:2: species: 'SM' is not a number (and 3 more) (plot 07"));
}

TEST_CASE("texts of a condition that do not occur, or with other spellings, are named") {
  Table table;
  TextColumn species;
  for (const char* text : {"Bu", "bu", "BU ", "Fi"}) species.append(text);
  table.set("species", species);
  CHECK(describe_compared_texts("species == \"Bu\"", table) ==
        "species has bu, BU  beside Bu, which the condition does not mean");
  CHECK(describe_compared_texts("species == \"Ta\" && species != \"Fi\"", table) ==
        "no row has the species Ta");
  CHECK(describe_compared_texts("species == \"Fi\"", table).empty());
}

TEST_CASE("a column called pi is no number in expressions") {
  Table table;
  table.set("pi", std::vector<double>{2.0, 200.0});
  CHECK_THROWS_WITH(rows_where("pi > 100", table), Contains("a column has this name"));
  CHECK(rows_where("`pi` > 100", table).rows() == 1);
}
