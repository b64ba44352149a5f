// SPDX-License-Identifier: MIT
#include "silvafit/study/table_checks.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "reference.hpp"
#include "silvafit/data/checked_columns.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

data::Table trees_to_check() {
  data::Table table;
  data::TextColumn plot;
  data::TextColumn species;
  for (const char* text : {"07", "07", "08", "08"}) plot.append(text);
  for (const char* text : {"SM", "BHN", "SM", "SM"}) species.append(text);
  table.set("plot", plot);
  table.set("tree", std::vector<double>{1.0, 2.0, 3.0, 4.0});
  table.set("species", species);
  table.set("dbh", std::vector<double>{10.0, 20.0, -3.0, data::kMissing});
  table.set("h", std::vector<double>{8.0, 15.0, 9.0, 10.0});
  table.set_origin("trees.csv", {2, 3, 4, 5});
  return table;
}

}  // namespace

TEST_CASE("columns may be computed from others") {
  data::Table table = trees_to_check();
  add_columns({{"d", "dbh/100"}, {"group", "plot"}, {"height", "h"}}, table);
  CHECK(table.numbers("d")[1] == 0.2);
  CHECK(table.text("group")[0] == "07");
  CHECK(table.numbers("height")[3] == 10.0);
  CHECK_THROWS_AS(add_columns({{"d", "nothing*2"}}, table), InputError);
}

TEST_CASE("a value outside a model's domain is an error with its place") {
  const Catalogue catalogue = Catalogue::load(test::source_file("models"));
  CHECK_THROWS_AS(require_domain(catalogue.find("M4"), trees_to_check()), DomainError);
  CHECK_THROWS_WITH(require_domain(catalogue.find("M4"), trees_to_check()),
                    Contains("trees.csv:4: dbh: -3 is outside the domain of the model") &&
                        Contains("(plot 08, tree 3, model M4)"));
  CHECK_NOTHROW(
      require_domain(catalogue.find("M4"), data::rows_where("dbh > 0", trees_to_check())));
  CHECK_THROWS_AS(require_domain_of_covariates(catalogue.find("M4"), trees_to_check()),
                  DomainError);
  CHECK_THROWS_WITH(require_domain(catalogue.find("M20"), trees_to_check()),
                    Contains("unknown column 'hcb'"));
}

TEST_CASE("an impossible measured value is an error with its place") {
  data::Table table;
  table.set("h", std::vector<double>{1.4, data::kMissing, 1.3});
  table.set("hcb", std::vector<double>{0.0, 0.1, data::kMissing});
  table.set("cw", std::vector<double>{0.1, 0.0, 2.0});
  table.set("age", std::vector<double>{-1.0, 0.0, 1.0});
  table.set_origin("trees.csv", {2, 3, 4});
  CHECK_THROWS_WITH(require_possible("h", table),
                    Contains("trees.csv:4: h: 1.3 m is not above breast height, 1.3 m"));
  CHECK_NOTHROW(require_possible("hcb", table));  // branches may begin at the ground
  CHECK_THROWS_WITH(require_possible("cw", table),
                    Contains("trees.csv:3: cw: 0 m is not above 0 m"));
  CHECK_NOTHROW(require_possible("age", table));
  CHECK_NOTHROW(require_possible("d", table));
  CHECK(leave_out_impossible("h", table) ==
        "1 row is skipped, the first: trees.csv:4: h: 1.3 m is not above breast height, 1.3 m");
  CHECK(std::isnan(table.numbers("h")[2]));
  CHECK(table.numbers("h")[0] == 1.4);
  CHECK(leave_out_impossible("h", table).empty());
  table.set("hcb", std::vector<double>{0.0, -0.1, 3.0});
  CHECK_THROWS_AS(require_possible("hcb", table), DomainError);
}

TEST_CASE("the error about a missing structural index has the remedy") {
  CHECK_THROWS_WITH(require_numbers(trees_to_check(), {"C"}), Contains("silvafit indices"));
}

TEST_CASE("crown bases above the top, and negative sizes of the user's models, are impossible") {
  data::Table table;
  table.set("dbh", std::vector<double>{20.0, 22.0, 24.0});
  table.set("h", std::vector<double>{10.0, -1.0, 0.5});
  table.set("hcb", std::vector<double>{12.0, 3.0, data::kMissing});
  CHECK_THROWS_WITH(require_possible("hcb", table), Contains("12 m is not below h 10 m"));
  CHECK_THROWS_WITH(require_not_negative("h", table), Contains("-1 m is not above breast height"));
  CHECK_NOTHROW(require_not_negative("hcb", table));
  CHECK(leave_out_negative("h", table).starts_with("1 row is skipped, the first: "));
  // A model of the user may have heights of seedlings.
  CHECK(table.numbers("h")[2] == 0.5);
  CHECK(std::isnan(table.numbers("h")[1]));
  data::Table other;
  other.set("h", std::vector<double>{-1.0});
  CHECK(leave_out_negative("h", other).empty());
}
