// SPDX-License-Identifier: MIT
#include "silvafit/fit/term_tests.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/summary.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// The yields of plants under two treatments of Dobson (1983), An Introduction to Statistical
/// Modelling, table 7.1; PlantGrowth in R.
data::Table plants() {
  data::Table table;
  table.set("weight", {4.17, 5.58, 5.18, 6.11, 4.50, 4.61, 5.17, 4.53, 5.33, 5.14,
                       4.81, 4.17, 4.41, 3.59, 5.87, 3.83, 6.03, 4.89, 4.32, 4.69,
                       6.31, 5.12, 5.54, 5.50, 5.37, 5.29, 4.92, 6.15, 5.80, 5.26});
  data::TextColumn group;
  std::vector<double> row;
  for (int i = 0; i < 30; ++i) {
    group.append(
        std::vector<std::string>{"ctrl", "trt1", "trt2"}[static_cast<std::size_t>(i / 10)]);
    row.push_back(i % 10);
  }
  table.set("group", group);
  table.set("row", row);
  return table;
}

std::vector<TermTest> tests_of(const std::vector<std::string>& sub_models,
                               const FitModelOptions& options = {}) {
  const data::Table table = plants();
  const ModelSpecification model = specify_model("weight ~ a + b*row", sub_models, table);
  return term_tests(fit_model(model, table, options).fit);
}

}  // namespace

TEST_CASE("the test of a factor is the F test of analysis of variance") {
  // R 4.2.2: anova(lm(weight ~ group, PlantGrowth)).
  const std::vector<TermTest> tests = tests_of({"a ~ group"}, {.fixed = {{"b", 0.0}}});
  REQUIRE(tests.size() == 2);
  CHECK(tests[0].term == "a");
  CHECK(tests[1].term == "a:group");
  CHECK(tests[1].numerator_df == 2);
  CHECK(tests[1].denominator_df == 27.0);
  CHECK(tests[1].f == Approx(4.846088).epsilon(1e-7));
  CHECK(tests[1].p == Approx(0.01590996).epsilon(1e-6));
}

TEST_CASE("the columns of a contrast matrix are one term") {
  // Polynomial contrasts of R, contr.poly(3): the F test of a factor is that of any contrasts, as
  // above, and linear and quadratic parts are no terms of the formula.
  const data::Table table = plants();
  ModelTexts texts{.formula = "weight ~ a + b*row"};
  texts.factors = {"group"};
  texts.sub_models = {
      "a ~ 1 + I(-0.7071067811865475*(group == \"ctrl\") + 0.7071067811865475*(group == \"trt2\"))"
      " + I(0.408248290463863*(group == \"ctrl\") - 0.816496580927726*(group == \"trt1\")"
      " + 0.408248290463863*(group == \"trt2\"))"};
  const FittedModel fit =
      fit_model(specify_model(texts, table), table, {.fixed = {{"b", 0.0}}}).fit;
  const std::vector<TermTest> tests = term_tests(fit);
  REQUIRE(tests.size() == 2);
  CHECK(tests[1].term == "a:group");
  CHECK(tests[1].numerator_df == 2);
  CHECK(tests[1].f == Approx(4.846088).epsilon(1e-7));
  CHECK_THAT(summary(fit), Catch::Contains("4.846") && Catch::Contains("0.0159"));
}

TEST_CASE("terms keep their comparisons and products") {
  const auto names = [](const std::vector<TermTest>& tests) {
    std::vector<std::string> result;
    for (const TermTest& test : tests) result.push_back(test.term);
    return result;
  };
  CHECK(names(tests_of({"a ~ group*log(row + 1)", "b ~ 1"})) ==
        std::vector<std::string>{"a", "a:group", "a:log(row + 1)", "a:group:log(row + 1)", "b"});
  CHECK(names(tests_of({"a ~ (group == \"trt2\")"})) ==
        std::vector<std::string>{"a", "a:(group == \"trt2\")", "b"});
}

TEST_CASE("the test of one coefficient is its t test") {
  const data::Table table = plants();
  const FittedModel fit = fit_model(specify_model("weight ~ a + b*row", {}, table), table).fit;
  const std::vector<TermTest> tests = term_tests(fit);
  for (std::size_t k = 0; k < tests.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(k);
    CHECK(tests[k].f == Approx(std::pow(fit.t_values()[at], 2)).epsilon(1e-12));
    CHECK(tests[k].p == Approx(fit.p_values()[at]).epsilon(1e-10));
  }
}
