// SPDX-License-Identifier: MIT
#include "silvafit/base/error.hpp"

#include <catch2/catch.hpp>

using silvafit::describe;
using silvafit::Place;

TEST_CASE("a place is rendered before the message, its subject behind it") {
  CHECK(describe({.file = "trees.csv", .line = 118, .column = "hcb", .plot = "07", .tree = "31"},
                 "14.2 m exceeds h 12.9 m") ==
        "trees.csv:118: hcb: 14.2 m exceeds h 12.9 m (plot 07, tree 31)");
  CHECK(describe({.line = 3}, "no header") == "line 3: no header");
  CHECK(describe({}, "nothing known") == "nothing known");
  CHECK(describe({.model = "M4"}, "not converged") == "not converged (model M4)");
}

TEST_CASE("an error carries its place as data") {
  const silvafit::DomainError error("must be positive", {.column = "dbh", .tree = "9"});
  CHECK(error.place().tree == "9");
  CHECK(error.message() == "must be positive");
  CHECK(std::string(error.what()) == "dbh: must be positive (tree 9)");
  CHECK_THROWS_AS(throw silvafit::DomainError("x"), silvafit::InputError);
}

TEST_CASE("a formula error points at the column") {
  const silvafit::FormulaError error("unknown name 'dhb'", "h ~ a*dhb", 7);
  CHECK(error.position() == 7);
  CHECK(std::string(error.what()) == "column 7: unknown name 'dhb'\n  h ~ a*dhb\n        ^");
}

TEST_CASE("a name with control characters cannot move a terminal's cursor") {
  const silvafit::InputError error("unknown species 'S\x1b[2J'", {.file = "a\x1b.csv"});
  CHECK(std::string(error.what()) == "a\\x1b.csv: unknown species 'S\\x1b[2J'");
}
