// SPDX-License-Identifier: MIT
#include "silvafit/fit/formula_parts.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::FormulaError;
using silvafit::data::Table;

namespace {

/// Two stands of two plots.
Table inventory() {
  Table table(4);
  table.set("h", {10.0, 12.0, 14.0, 17.0});
  table.set("dbh", {10.0, 20.0, 30.0, 40.0});
  table.set("age", {20.0, 30.0, 50.0, 60.0});
  table.set("plot", {1.0, 2.0, 3.0, 4.0});
  table.set("stand", {1.0, 1.0, 2.0, 2.0});
  silvafit::data::TextColumn species;
  for (const char* name : {"A", "B", "A", "B"}) species.append(name);
  table.set("species", species);
  return table;
}

/// The random effects of a formula, as the text of --random.
std::string random_of(const std::string& formula) {
  std::string text;
  for (const RandomEffects& term : specify_model({.formula = formula}, inventory()).random) {
    text += (text.empty() ? "" : "; ") + term.text() + " | " + term.group;
  }
  return text;
}

}  // namespace

// The models are those of lme4: (1 | g) is a random intercept, (x | g) one with a random slope.
TEST_CASE("a bar term is the random effect of the coefficient whose derivative it is") {
  CHECK(random_of("h ~ a + b*dbh + (1 | plot)") == "a | plot");
  CHECK(random_of("h ~ a + b*dbh + (dbh | plot)") == "a + b | plot");
  CHECK(random_of("h ~ a + b*dbh + (1 + dbh | plot)") == "a + b | plot");
  CHECK(random_of("h ~ a + b*dbh + (0 + dbh | plot)") == "b | plot");
  CHECK(random_of("h ~ a + b*dbh + (dbh - 1 | plot)") == "b | plot");
  CHECK(random_of("h ~ (1 | plot) + a + b*dbh") == "a | plot");
  CHECK(random_of("h ~ a + b*log(dbh) + (log(dbh) | plot)") == "a + b | plot");
}

TEST_CASE("uncorrelated bar terms are blocks") {
  CHECK(random_of("h ~ a + b*dbh + (dbh || plot)") == "(a) + b | plot");
  CHECK(random_of("h ~ a + b*dbh + (1 | plot) + (0 + dbh | plot)") == "(a) + b | plot");
}

TEST_CASE("groupings of bar terms are nested, the coarser first") {
  CHECK(random_of("h ~ a + b*dbh + (1 | stand/plot)") == "a | stand; a | plot");
  CHECK(random_of("h ~ a + b*dbh + (1 | plot) + (1 | stand)") == "a | stand; a | plot");
  CHECK(random_of("h ~ a + b*dbh + (1 | stand) + (1 | stand:plot)") == "a | stand; a | plot");
}

TEST_CASE("groupings of bar terms are crossed where labels recur, and combinations of columns") {
  const auto terms_of = [](const std::string& formula) {
    return specify_model({.formula = formula}, inventory()).random;
  };
  // Each plot has one species and each species plots of both stands.
  const auto crossed = terms_of("h ~ a + b*dbh + (1 | stand) + (1 | species)");
  REQUIRE(crossed.size() == 2);
  CHECK(are_crossed(crossed));
  CHECK_FALSE(are_crossed(terms_of("h ~ a + b*dbh + (1 | stand) + (1 | plot)")));
  const auto combined = terms_of("h ~ a + b*dbh + (1 | stand:species)");
  REQUIRE(combined.size() == 1);
  CHECK(combined.front().group_text() == "stand:species");
  CHECK(terms_of("h ~ a + b*dbh + (1 | stand/plot) + (1 | species)").size() == 3);
}

TEST_CASE("bar terms with parameters are those of nlmer") {
  CHECK(random_of("h ~ 1.3 + a*(1 - exp(-b*dbh)) + (a | plot)") == "a | plot");
  CHECK(random_of("h ~ 1.3 + a*(1 - exp(-b*dbh)) + (a + b | plot)") == "a + b | plot");
}

TEST_CASE("a bar term that is no effect of a coefficient is refused with the coefficients") {
  CHECK_THROWS_WITH(random_of("h ~ 1.3 + a*(1 - exp(-b*dbh)) + (1 | plot)"),
                    Contains("(1 | plot) is not the effect of one coefficient") &&
                        Contains("(coefficients: a, b)"));
  CHECK_THROWS_AS(random_of("h ~ a + b*dbh + (age | plot)"), FormulaError);
  CHECK_THROWS_AS(random_of("h ~ a + b*dbh + (species | plot)"), FormulaError);
  CHECK_THROWS_WITH(random_of("h ~ a + b*dbh | plot"), Contains("`random=a | plot`"));
  CHECK_THROWS_WITH(random_of("h ~ a*dbh^b ~ a | plot"), Contains("`random=a | plot`"));
  CHECK_THROWS_WITH(
      specify_model({.formula = "h ~ a + b*dbh + (1 | plot)", .random = "b | plot"}, inventory()),
      Contains("in the formula and by `random`"));
}

TEST_CASE("bars between conditions are a logical or") {
  const FormulaParts parts = split_formula("h ~ a + b*dbh + (dbh > 20 || age > 40)");
  CHECK(parts.bars.empty());
  CHECK_THROWS_WITH(random_of("h ~ a + b*dbh - (1 || plot)"), Contains("random effects"));
  CHECK_THROWS_WITH(
      specify_model({.formula = "h ~ a + b*dbh", .sub_models = {"a ~ 1 + (1 | plot)"}},
                    inventory()),
      Contains("random effects"));
}

TEST_CASE("formulas of lm and lme4 are refused with the formula to write") {
  CHECK_THROWS_WITH(random_of("h ~ age"), Contains("h ~ b0 + b1*age"));
  CHECK_THROWS_WITH(random_of("h ~ 1"), Contains("h ~ b0"));
  CHECK_THROWS_WITH(random_of("h ~ age - 1"), Contains("h ~ b0*age"));
  CHECK_THROWS_WITH(random_of("h ~ age*dbh"), Contains("h ~ b0 + b1*age + b2*dbh + b3*age*dbh"));
  CHECK_THROWS_WITH(random_of("h ~ age + species"),
                    Contains("h ~ b0 + b1*age with `parameters=b0 ~ species`"));
  CHECK_THROWS_WITH(random_of("h ~ age + (1 | plot)"),
                    Contains("h ~ b0 + b1*age with `random=b0 | plot`"));
  CHECK_THROWS_WITH(random_of("h ~ age + (age | plot)"), Contains("`random=b0 + b1 | plot`"));
}

TEST_CASE("random effects can be written as in nlme and lme4") {
  CHECK(parse_random_effects("a + b ~ 1 | plot").front().coefficients ==
        std::vector<std::string>{"a", "b"});
  CHECK(parse_random_effects("(a | plot)").front().group == "plot");
  CHECK_THROWS_WITH(parse_random_effects("a ~ C | plot"), Contains("a + a:C | plot"));
}
