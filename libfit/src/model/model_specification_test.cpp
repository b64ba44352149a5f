// SPDX-License-Identifier: MIT
#include "silvafit/fit/model_specification.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

using namespace silvafit::fit;
using silvafit::FormulaError;
using silvafit::data::Table;

namespace {

Table columns(std::initializer_list<const char*> names) {
  Table table(1);
  for (const char* name : names) table.set(name, std::vector<double>{1.0});
  return table;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("names that are not columns are parameters, in order") {
  const auto model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))^c", {}, columns({"h", "dbh"}));
  CHECK(model.formula.left == "h");
  CHECK(model.coefficient_names() == Names{"a", "b", "c"});
}

TEST_CASE("a parameter that a zero removes from the formula is refused, a column is not") {
  CHECK_THROWS_WITH(specify_model("h ~ a + 0*b*dbh", {}, columns({"h", "dbh"})),
                    Catch::Contains("column 11: the value does not depend on 'b'"));
  CHECK(specify_model("h ~ a + 0*dbh", {}, columns({"h", "dbh"})).coefficient_names() ==
        Names{"a"});
}

TEST_CASE("pi is a number, and the name of a column in backquotes only") {
  CHECK(specify_model("h ~ a + pi*dbh", {}, columns({"h", "dbh"})).predictors() == Names{"dbh"});
  const Table table = columns({"h", "dbh", "pi"});
  const auto model = specify_model("h ~ a + `pi`*dbh", {"a ~ `pi`"}, table);
  CHECK(model.formula.right.text() == "a + `pi`*dbh");
  CHECK_THROWS_WITH(specify_model("h ~ a + pi*dbh", {}, table),
                    Catch::Contains("column 9: pi is 3.14159"));
  CHECK_THROWS_AS(specify_model("h ~ a*dbh", {"a ~ I(2*pi)"}, table), FormulaError);
  CHECK_NOTHROW(specify_model("h ~ a*dbh + pine", {}, table));
}

TEST_CASE("sub-models add coefficients named parameter:covariate") {
  const auto table = columns({"h", "dbh", "C", "U"});
  const auto model = specify_model(
      "h ~ 1.3 + a*(1 - exp(-b*dbh))", {"b ~ 1 + C + C:U", "a ~ 0 + log(dbh + 1)"}, table);
  CHECK(model.coefficient_names() == Names{"a:log(dbh + 1)", "b", "b:C", "b:C:U"});
  CHECK(model.parameters[1].text() == "1 + C + C:U");
  CHECK(model.parameters[1].covariates[1].value.text() == "C*U");
}

TEST_CASE("a parameter of one letter may differ from a column only by its case") {
  const auto model =
      specify_model("cw ~ a/(1 + b*exp(-c*dbh))", {"c ~ 1 + C"}, columns({"cw", "dbh", "C"}));
  CHECK(model.coefficient_names() == Names{"a", "b", "c", "c:C"});
}

TEST_CASE("a colon in quotes is text, elsewhere a product") {
  Table table(2);
  table.set("dbh", {1.0, 2.0});
  table.set("h", {1.0, 2.0});
  silvafit::data::TextColumn kind;
  kind.append("A:B");
  kind.append("A + B");
  table.set("kind", kind);
  const ModelSpecification model =
      specify_model("h ~ a*dbh", {R"(a ~ 1 + dbh:(kind == "A:B") + (kind == "A + B"))"}, table);
  REQUIRE(model.parameters[0].covariates.size() == 2);
  // As in R, products follow single variables.
  const auto values = silvafit::data::evaluate(model.parameters[0].covariates[1].value, table);
  CHECK(values == std::vector<double>{1.0, 0.0});
  CHECK(model.label_columns() == std::vector<std::string>{"kind"});
}

TEST_CASE("different nested groups have different labels") {
  CHECK(nested_label("A", "1") == "A/1");
  CHECK(nested_label("A", "1/1") == "A/1/1");
  CHECK(nested_label("A/1", "1") == "A%2F1/1");
  for (const std::string outer : {"A", "A/1", ""}) {
    const std::string label = nested_label(outer, "1/2");
    CHECK(nested_parts(label).outer == outer_part(outer));
    CHECK(nested_parts(label).inner == "1/2");
  }
}

TEST_CASE("errors have the unknown name and its position") {
  const auto table = columns({"h", "dbh"});
  CHECK_THROWS_WITH(specify_model("h ~ a*DBH", {}, table),
                    Catch::Matchers::Contains("did you mean 'dbh'"));
  CHECK_THROWS_WITH(specify_model("h ~ a*dbh", {"b ~ 1"}, table),
                    Catch::Matchers::Contains("unknown parameter 'b'"));
  CHECK_THROWS_WITH(specify_model("h ~ a*dbh", {"a ~ 1 + Q"}, table),
                    Catch::Matchers::Contains("column 9: unknown column 'Q'"));
  CHECK_THROWS_AS(specify_model("h ~ a*dbh", {"a ~ 0"}, table), FormulaError);
  CHECK_THROWS_AS(specify_model("h ~ a*dbh", {"a ~ 1 +"}, table), FormulaError);
  CHECK_THROWS_AS(specify_model("h ~ a*dbh", {"a = 1"}, table), FormulaError);
}

TEST_CASE("texts of a model are checked, with positions in messages") {
  const auto table = columns({"h", "dbh", "plot"});
  CHECK_THROWS_WITH(specify_model("h ~ 2*dbh", {}, table),
                    Catch::Matchers::Contains("nothing to estimate"));
  CHECK_THROWS_WITH(check_response(specify_model("h ~ a + b*h", {}, table), table),
                    Catch::Matchers::Contains("'h' cannot predict itself"));
  CHECK_THROWS_WITH(check_response(specify_model("h ~ a*dbh", {"a ~ 1 + h"}, table), table),
                    Catch::Matchers::Contains("'h' cannot predict itself"));
  CHECK_THROWS_WITH(check_response(specify_model("log(h) ~ a + b*h", {}, table), table),
                    Catch::Matchers::Contains("'h' cannot predict itself"));
  auto of_groups = specify_model("log(h) ~ a + b*dbh", {}, table);
  CHECK_NOTHROW(check_response(of_groups, table));
  add_random_effects(of_groups, "a | h", table);
  CHECK_THROWS_WITH(check_response(of_groups, table),
                    Catch::Matchers::Contains("'h' cannot predict itself"));
  auto of_variance = specify_model("h ~ a*dbh", {}, table);
  for (const std::string text : {"power(`d (cm)` | `plot/no`)", "stratum(`sp=x`)"}) {
    CHECK(parse_variance_function(text).text() == text);
  }
  CHECK(parse_variance_function("power(`d b h` | `plot no`)").factors.front().column == "d b h");
  of_variance.variance = parse_variance_function("power(h)");
  CHECK_THROWS_WITH(check_response(of_variance, table),
                    Catch::Matchers::Contains("'h' cannot predict itself"));
  // Tapers and slendernesses are ratios to a predictor.
  CHECK_NOTHROW(check_response(specify_model("h/dbh ~ a + b*dbh", {}, table), table));
  CHECK_THROWS_WITH(check_response(specify_model("H ~ a*dbh", {}, table), table),
                    Catch::Matchers::Contains("column 1: unknown column 'H'"));
  auto model = specify_model("h ~ a + b*dbh", {}, table);
  CHECK_THROWS_WITH(add_random_effects(model, "a + q | plot", table),
                    Catch::Matchers::Contains("column 5: unknown coefficient 'q'"));
  CHECK_THROWS_WITH(add_random_effects(model, "a + a | plot", table),
                    Catch::Matchers::Contains("column 5: 'a' is given twice"));
  CHECK_THROWS_WITH(add_random_effects(model, "a | site", table),
                    Catch::Matchers::Contains("column 5: unknown column 'site'"));
  add_random_effects(model, "a + b | plot", table);
  CHECK(model.random.front().coefficients == Names{"a", "b"});
}

TEST_CASE("blocks and nested groupings of random effects are read") {
  const auto blocks = parse_random_effects("(a + b) + c | plot");
  CHECK(blocks[0].covariance == Covariance::kBlock);
  CHECK(blocks[0].coefficients == Names{"a", "b", "c"});
  CHECK(blocks[0].blocks == std::vector<int>{2, 1});
  CHECK(blocks[0].text() == "(a + b) + c");

  const auto nested = parse_random_effects("a | stand/plot");
  REQUIRE(nested.size() == 2);
  CHECK(nested[0].group == "stand");
  CHECK(nested[1].group == "plot");
  CHECK(nested[0].coefficients == Names{"a"});
  const auto own = parse_random_effects("a | stand; a + b | plot");
  CHECK(own[0].coefficients == Names{"a"});
  CHECK(own[1].coefficients == Names{"a", "b"});
  CHECK(own[1].group_text() == "plot");
  CHECK(parse_random_effects("a | `plot no`").front().group == "plot no");
  CHECK(parse_random_effects("a | `plot/no`").front().group == "plot/no");
  const auto within = parse_random_effects("a | stand; a + b | stand/plot");
  REQUIRE(within.size() == 2);
  CHECK(within[0].coefficients == Names{"a"});
  CHECK(within[0].group == "stand");
  CHECK(within[1].coefficients == Names{"a", "b"});
  CHECK(within[1].group == "plot");
  CHECK(within[1].group_text() == "stand/plot");
  CHECK_THROWS_AS(parse_random_effects("a | stand/plot; a | stand/plot"), FormulaError);
  // As lme4 reads it, the sum has two effects of stand.
  CHECK_THROWS_WITH(parse_random_effects("(b | stand) + (a | stand/plot)"),
                    Catch::Matchers::Contains("the groups of stand are given twice"));
  CHECK_THROWS_AS(parse_random_effects("a | plot/plot"), FormulaError);
  CHECK_THROWS_AS(parse_random_effects("() | plot"), FormulaError);
}

TEST_CASE("labels that recur in several coarser groups need a nested grouping") {
  const auto table_of = [](const std::vector<std::array<const char*, 2>>& rows) {
    Table table;
    silvafit::data::TextColumn site;
    silvafit::data::TextColumn year;
    for (const auto& [a, b] : rows) {
      *a == '\0' ? site.append_missing() : site.append(a);
      year.append(b);
    }
    table.set("site", site);
    table.set("yr", year);
    table.set("y", std::vector<double>(rows.size(), 1.0));
    table.set("x", std::vector<double>(rows.size(), 1.0));
    return table;
  };
  using Catch::Matchers::Contains;
  const auto add = [](const Table& table, const char* random) {
    ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
    add_random_effects(model, random, table);
  };
  const Table crossed = table_of({{"P", "1"}, {"P", "2"}, {"Q", "1"}, {"Q", "2"}});
  CHECK_THROWS_WITH(
      add(crossed, "a | site; a | yr"),
      Contains("yr recurs in every site: for yr within site") && Contains("`a | site/yr`"));
  CHECK_THROWS_WITH(add(crossed, "a | site; a + b | yr"),
                    Contains("`a | site; a + b | site/yr`") && Contains("crossed random effects"));
  CHECK_THROWS_WITH(add(crossed, "a | site; a | yr"), Contains("`a | site + yr`"));
  CHECK_THROWS_WITH(add(crossed, "a | site; a + b | yr"), Contains("`(a | site) + (a + b | yr)`"));
  CHECK_NOTHROW(add(crossed, "(a | site); (a + b | yr)"));
  CHECK_THROWS_WITH(add(crossed, "a | x; a | site; a | yr"),
                    Contains("`a | x/site/yr`") && Contains("`(a | x); (a | site); (a | yr)`"));
  CHECK_NOTHROW(add(crossed, "a | x/site/yr"));
  CHECK_NOTHROW(add(crossed, "(a | x); (a | site); (a | yr)"));
  CHECK_NOTHROW(add(crossed, "a | site/yr"));
  CHECK_NOTHROW(add(crossed, "a | site; a + b | site/yr"));

  // One label of three is enough.
  const Table partly = table_of({{"P", "1"}, {"P", "2"}, {"Q", "1"}, {"Q", "3"}});
  CHECK_THROWS_WITH(add(partly, "a | site; a | yr"),
                    Contains("1 of 3 labels of yr recur in several groups of site"));
  const Table nested = table_of({{"P", "1"}, {"P", "2"}, {"Q", "3"}, {"Q", "4"}, {"", "1"}});
  CHECK_NOTHROW(add(nested, "a | site; a | yr"));
  CHECK_THROWS_WITH(add(nested, "a | yr; a | site"),
                    Contains("write it first: `a | site/yr`") && Contains("coarser grouping"));
}

TEST_CASE("products, strata and held parameters of variance functions are read") {
  const std::string text = "stratum(species) * power(fitted | layer, delta = 0.5)";
  const VarianceFunction function = parse_variance_function(text);
  REQUIRE(function.factors.size() == 2);
  CHECK(function.factors[0].kind == VarianceFactor::Kind::kStratum);
  CHECK(function.factors[0].stratum == "species");
  CHECK(function.factors[1].stratum == "layer");
  CHECK(function.factors[1].column.empty());
  CHECK(function.factors[1].delta == 0.5);
  CHECK(function.text() == text);
  CHECK(parse_variance_function("none").is_constant());
  CHECK(parse_variance_function("constant-plus-power(dbh, constant = 1)").parameter_count() == 1);
  CHECK_THROWS_AS(parse_variance_function("power(dbh"), FormulaError);
  CHECK_THROWS_AS(parse_variance_function("power(constant = 1)"), FormulaError);
  CHECK_THROWS_AS(parse_variance_function("stratum"), FormulaError);
}

TEST_CASE("random effects and variance functions are read") {
  const auto random = parse_random_effects("a + b + b:C | plot");
  REQUIRE(random.size() == 1);
  CHECK(random[0].coefficients == Names{"a", "b", "b:C"});
  CHECK(random[0].group == "plot");
  CHECK(random[0].covariance == Covariance::kGeneral);
  CHECK_THROWS_AS(parse_random_effects("a + b"), FormulaError);

  const auto groups_of = [](const char* text) {
    Names result;
    for (const RandomEffects& term : parse_random_effects(text)) {
      result.push_back(term.text() + " | " + term.group_text());
    }
    return result;
  };
  CHECK(groups_of("a | stand/plot") == Names{"a | stand", "a | stand/plot"});
  CHECK(groups_of("a | stand; a + b | stand/plot") == Names{"a | stand", "a + b | stand/plot"});
  CHECK(groups_of("a | plot + year") == Names{"a | plot", "a | year"});
  CHECK(groups_of("(a + b | plot) + (a | year)") == Names{"a + b | plot", "a | year"});
  CHECK(groups_of("a | region/stand/plot") ==
        Names{"a | region", "a | region:stand", "a | region:stand:plot"});
  CHECK(groups_of("a | stand/plot + year") == Names{"a | stand", "a | stand:plot", "a | year"});
  CHECK(groups_of("a | recipe:replicate") == Names{"a | recipe:replicate"});
  // The text of crossed terms is read as the same terms.
  CHECK(groups_of("a | region; a | region:stand; b | region:stand:plot") ==
        Names{"a | region", "a | region:stand", "b | region:stand:plot"});
  CHECK_FALSE(are_crossed(parse_random_effects("a | stand; a | plot")));
  CHECK(are_crossed(parse_random_effects("a | stand + plot")));
  CHECK_THROWS_AS(parse_random_effects("a | plot + plot"), FormulaError);
  CHECK_THROWS_AS(parse_random_effects("a | plot/plot"), FormulaError);
  CHECK_THROWS_AS(parse_random_effects("a | plot +"), FormulaError);
  CHECK_THROWS_AS(parse_random_effects("a + | plot"), FormulaError);
  CHECK_THROWS_AS(parse_random_effects("a |"), FormulaError);

  const auto power = parse_variance_function("power(dbh)");
  REQUIRE(power.factors.size() == 1);
  CHECK(power.factors[0].kind == VarianceFactor::Kind::kPower);
  CHECK(power.factors[0].column == "dbh");
  CHECK(power.text() == "power(dbh)");
  CHECK(parse_variance_function("constant-plus-power").parameter_count() == 2);
  CHECK_THROWS_AS(parse_variance_function("cubic"), silvafit::UsageError);
  CHECK(silvafit::word_of(parse_covariance("diagonal")) == "diagonal");
  CHECK_THROWS_AS(parse_covariance("round"), silvafit::UsageError);
}
