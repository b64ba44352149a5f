// SPDX-License-Identifier: MIT
#include "silvafit/study/column_uses.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"

using silvafit::study::column_uses;
using silvafit::study::ColumnUses;
using silvafit::study::name_columns;

TEST_CASE("the columns of a model are found in its texts") {
  const ColumnUses uses = column_uses({.formulas = {"h ~ 1.3 + a*(1 - exp(-b*dbh))"},
                                       .parameters = {"b ~ 1 + C + factor(site)"},
                                       .where = "species == \"SM\" && core == 1",
                                       .random = "a | stand/plot",
                                       .variance = "power(d6 | layer)"});
  CHECK(uses.as_numbers == std::set<std::string>{"h", "a", "b", "dbh", "C", "core", "d6"});
  CHECK(uses.as_names == std::set<std::string>{"site", "species", "stand", "plot", "layer"});
}

TEST_CASE("all columns of a grouping are names") {
  const ColumnUses uses = column_uses({.formulas = {"h ~ a"}, .random = "a | r:t + u/v:w"});
  CHECK(uses.as_names == std::set<std::string>{"r", "t", "u", "v", "w"});
}

TEST_CASE("bar terms in a formula read their effects and the columns of their groups") {
  const ColumnUses uses = column_uses({.formulas = {"h ~ a + b*dbh + (1 + age | stand/plot)"}});
  CHECK(uses.as_numbers == std::set<std::string>{"h", "a", "b", "dbh", "age"});
  CHECK(uses.as_names == std::set<std::string>{"stand", "plot"});
}

TEST_CASE("columns that are read as numbers, too, do not keep their spelling") {
  CHECK(name_columns({.formulas = {"h ~ a + b*plot"}, .random = "a | block"}) ==
        std::vector<std::string>{"block", "species", "tree"});
  CHECK_THROWS_AS(column_uses({.formulas = {"h ~ (a"}}), silvafit::FormulaError);
}
