// SPDX-License-Identifier: MIT
#include "silvafit/fit/response.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using ColumnNames = std::vector<std::string>;

namespace {

data::Table measured_trees() {
  data::Table table(4);
  table.set("h", {8.0, 12.0, 15.0, 17.0});
  table.set("dbh", {10.0, 20.0, 30.0, 40.0});
  return table;
}

}  // namespace

TEST_CASE("a response reads the columns of its expression") {
  CHECK(response_of("log(h) ~ a + b*dbh + (1 | plot)") == "log(h)");
  CHECK(response_columns("h") == ColumnNames{"h"});
  CHECK(response_columns("(h - hcb)/h") == ColumnNames{"h", "hcb"});
  CHECK(response_columns("crown width [m]") == ColumnNames{"crown width [m]"});
}

TEST_CASE("the fit of an expression is that of a column with its values") {
  data::Table table = measured_trees();
  add_response("log(h)", table);
  std::vector<double> logarithms;
  for (const double h : {8.0, 12.0, 15.0, 17.0}) logarithms.push_back(std::log(h));
  table.set("column", logarithms);
  const auto estimate = [&table](const char* formula) {
    return fit_model(specify_model({.formula = formula}, table), table).fit.estimate;
  };
  CHECK(estimate("log(h) ~ a + b*log(dbh)") == estimate("column ~ a + b*log(dbh)"));
}

TEST_CASE("a response is added where its columns are, and has to be defined") {
  data::Table table = measured_trees();
  add_response("h", table);
  add_response("log(hcb)", table);
  CHECK(table.names() == ColumnNames{"h", "dbh"});
  table.set("h", {8.0, data::kMissing, 0.0, 17.0});
  CHECK_THROWS_WITH(add_response("log(h)", table), Contains("not defined"));
  CHECK_THROWS_AS(add_response("log(h)", table), InputError);
  add_response("sqrt(h)", table);
  CHECK(std::isnan(table.numbers("sqrt(h)")[1]));
  CHECK(table.numbers("sqrt(h)")[2] == 0.0);
  CHECK_THROWS_WITH(specify_model({.formula = "log(hh) ~ a + b*dbh"}, table), Contains("hh"));
}
