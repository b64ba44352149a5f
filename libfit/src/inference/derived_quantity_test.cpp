// SPDX-License-Identifier: MIT
#include "silvafit/fit/derived_quantity.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "test_support/saturating_curve.hpp"

using namespace silvafit;
using namespace silvafit::fit;

namespace {

/// NIST's data set Misra1a.
data::Table misra() {
  data::Table table;
  table.set("y",
            {10.07,
             14.73,
             17.94,
             23.93,
             29.61,
             35.18,
             40.02,
             44.82,
             50.76,
             55.05,
             61.01,
             66.40,
             75.47,
             81.78});
  table.set("x",
            {77.6,
             114.9,
             141.1,
             190.8,
             239.9,
             289.0,
             332.8,
             378.4,
             434.8,
             477.3,
             536.8,
             593.1,
             689.1,
             760.0});
  return table;
}

FittedModel misra_fit(const std::vector<std::string>& derived,
                      const FitModelOptions& options = {}) {
  const data::Table table = misra();
  const ModelSpecification model =
      specify_model({.formula = "y ~ b1*(1 - exp(-b2*x))", .derived = derived}, table);
  return fit_model(model, table, options).fit;
}

}  // namespace

TEST_CASE("a derived quantity has the standard error and interval of a model that has it") {
  const FittedModel fit = misra_fit({"slope = b1*b2", "y1000 = b1*(1 - exp(-1000*b2))"});
  // R 4.2.2: summary and confint of nls(y ~ s/b2*(1 - exp(-b2*x))) and
  // nls(y ~ q*(1 - exp(-b2*x))/(1 - exp(-1000*b2))), which are accurate to 1e-8.
  const std::vector<DerivedValue> values = derived_values(fit);
  REQUIRE(values.size() == 2);
  CHECK(values[0].estimate == Approx(0.131455549).epsilon(1e-8));
  CHECK(values[0].standard_error == Approx(2.595758e-4).epsilon(1e-6));
  CHECK(values[0].degrees_of_freedom == 12.0);
  CHECK(values[1].estimate == Approx(101.1060767).epsilon(1e-8));
  CHECK(values[1].standard_error == Approx(0.15326086).epsilon(1e-6));
  const Intervals profiles =
      confidence_intervals(fit, misra(), {.method = IntervalMethod::kProfile});
  const ParameterInterval& slope = profiles.parameters[3];
  CHECK(slope.name == "slope");
  CHECK(slope.kind == ParameterKind::kDerived);
  CHECK(slope.lower == Approx(0.1308903158).epsilon(1e-7));
  CHECK(slope.upper == Approx(0.1320229409).epsilon(1e-7));
  CHECK(profiles.parameters[4].lower == Approx(100.7723842).epsilon(1e-7));
  CHECK(profiles.parameters[4].upper == Approx(101.4410634).epsilon(1e-7));
  const Intervals wald = confidence_intervals(fit, misra());
  // The 97.5 % quantile of t with 12 degrees of freedom.
  CHECK(wald.parameters.back().lower ==
        Approx(101.1060767 - 2.1788128297 * 0.15326086).epsilon(1e-8));
}

TEST_CASE("a coefficient that is held has no error in a derived quantity") {
  const FittedModel fit = misra_fit({"slope = b1*b2"}, {.fixed = {{"b2", 5.5e-4}}});
  const DerivedValue value = derived_values(fit)[0];
  CHECK(value.standard_error == Approx(5.5e-4 * fit.standard_errors()[0]).epsilon(1e-12));
  const Intervals profiles =
      confidence_intervals(fit, misra(), {.method = IntervalMethod::kProfile});
  CHECK(profiles.parameters.back().upper ==
        Approx(5.5e-4 * profiles.parameters.front().upper).epsilon(1e-8));
}

TEST_CASE("differences of levels are derived quantities, in files and in the bootstrap") {
  data::Table table;  // PlantGrowth in R; Dobson 1983
  table.set("weight", {4.17, 5.58, 5.18, 6.11, 4.50, 4.61, 5.17, 4.53, 5.33, 5.14,
                       4.81, 4.17, 4.41, 3.59, 5.87, 3.83, 6.03, 4.89, 4.32, 4.69,
                       6.31, 5.12, 5.54, 5.50, 5.37, 5.29, 4.92, 6.15, 5.80, 5.26});
  data::TextColumn group;
  for (int i = 0; i < 30; ++i) group.append(i < 10 ? "ctrl" : i < 20 ? "trt1" : "trt2");
  table.set("group", group);
  table.set("one", std::vector<double>(30, 1.0));
  const ModelTexts texts{
      .formula = "weight ~ a*one",
      .sub_models = {"a ~ group"},
      .derived = {"difference = `a:(group == \"trt2\")` - `a:(group == \"trt1\")`"}};
  const FittedModel fit = fit_model(specify_model(texts, table), table).fit;
  // R 4.2.2: lm(weight ~ group, PlantGrowth).
  CHECK(derived_values(fit)[0].estimate == Approx(0.865).epsilon(1e-12));
  CHECK(derived_values(fit)[0].standard_error == Approx(0.2787816084).epsilon(1e-9));
  const FittedModel read = from_json(to_json(fit), "file");
  CHECK(derived_values(read)[0].standard_error == derived_values(fit)[0].standard_error);
  const Bootstrap drawn = bootstrap(fit, table, {.replicates = 400});
  CHECK(drawn.parameters.back().name == "difference");
  // The parametric bootstrap draws from sigma with n - p; its error is 1/sqrt(2 * 400) = 3.5 %.
  CHECK(drawn.parameters.back().standard_error == Approx(0.2787816084).epsilon(0.1));
}

TEST_CASE("an error is unknown if a coefficient is not identifiable") {
  FittedModel fit = misra_fit({"slope = b1*b2", "half = b2/2"});
  fit.covariance.row(0).setConstant(kNaN);
  fit.covariance.col(0).setConstant(kNaN);
  CHECK(std::isnan(derived_values(fit)[0].standard_error));
  CHECK(derived_values(fit)[1].standard_error == Approx(0.5 * fit.standard_errors()[1]));
}

TEST_CASE("texts of derived quantities are checked") {
  const std::vector<std::string> names{"a", "b"};
  CHECK(parse_derived_quantity(" a/b ", names).name == "a/b");
  CHECK_THROWS_AS(parse_derived_quantity("c = a*bb", names), FormulaError);
  CHECK_THROWS_AS(parse_derived_quantity("b = 2*a", names), FormulaError);
  CHECK_THROWS_AS(parse_derived_quantity("c = 3", names), FormulaError);
  CHECK_THROWS_AS(parse_derived_quantity("= a", names), FormulaError);
  CHECK_THROWS_AS(parse_derived_quantity("c =", names), FormulaError);
  CHECK_THROWS_AS(parse_derived_quantity("sigma = a", names), FormulaError);
  CHECK_THROWS_AS(misra_fit({"c = b1*b2", "c = b1"}), FormulaError);
}

TEST_CASE("profiles of a mean along a ridge have both limits") {
  const data::Table table = saturating();
  const ModelSpecification model = specify_model(
      {.formula = "y ~ A*(1 - exp(-k*x))",
       .derived = {"m5 = A*(1 - exp(-5*k))", "m8 = A*(1 - exp(-8*k))", "m10 = A*(1 - exp(-10*k))"}},
      table);
  const Intervals found = confidence_intervals(
      fit_model(model, table).fit, table, {.method = IntervalMethod::kProfile});
  // The roots of the sum of squares with the mean as a coefficient, by scipy (brentq over
  // minimize_scalar); R's confint() of nls agrees to its four digits.
  const std::vector<std::pair<double, double>> limits{{6.498444195996576, 7.17432773856094},
                                                      {9.346413922771392, 10.050335171379974},
                                                      {10.600606531926353, 11.87303039192891}};
  std::size_t next = 0;
  for (const ParameterInterval& one : found.parameters) {
    if (one.kind != ParameterKind::kDerived) continue;
    INFO(one.name << ": " << one.note);
    REQUIRE(next < limits.size());
    // Roots of the deviance to 1e-6 of its size: about 1e-7 of these values.
    CHECK(one.lower == Approx(limits[next].first).epsilon(1e-6));
    CHECK(one.upper == Approx(limits[next].second).epsilon(1e-6));
    CHECK(one.note.empty());
    ++next;
  }
  CHECK(next == 3);
}

TEST_CASE("a quantity without a finite value at the estimates is refused") {
  for (const auto& [text, name] : {std::pair{"r = log(10 - b1)", "quantity r "},
                                   std::pair{"u = 1/(b1 - b1)", "quantity u "}}) {
    const FittedModel fit = misra_fit({text});
    REQUIRE(fit.convergence.converged());
    CHECK_THROWS_WITH(derived_values(fit), Catch::Matchers::Contains(name));
  }
}

TEST_CASE("the profile of a ratio whose denominator may be 0 is Fieller's set") {
  data::Table table;
  table.set("x", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  table.set("y", {1.2, 0.8, 1.5, 0.6, 1.1, 0.9, 1.4, 0.7, 1.3, 1.1});
  const ModelSpecification model =
      specify_model(ModelTexts{.formula = "y ~ a + b*x", .derived = {"r = a/b"}}, table);
  const FittedModel fit = fit_model(model, table, {.method = Method::kOrdinary}).fit;
  // (a - r b)^2 = t^2 (V11 - 2 r V12 + r^2 V22), t the 97.5 % quantile with 8 degrees of freedom.
  constexpr double kT = 2.306004135204166;
  const double a = fit.estimate[0];
  const double b = fit.estimate[1];
  const Eigen::Matrix2d v = kT * kT * fit.covariance;
  const double square = b * b - v(1, 1);
  const double linear = a * b - v(0, 1);
  const double root = std::sqrt(linear * linear - square * (a * a - v(0, 0)));
  REQUIRE(square < 0.0);  // the set is what lies outside of the roots
  const double low = (linear + root) / square;
  const double high = (linear - root) / square;
  const ParameterInterval ratio =
      confidence_intervals(fit, table, {.method = IntervalMethod::kProfile}).parameters.back();
  REQUIRE(ratio.name == "r");
  const bool is_above = ratio.estimate > high;
  CHECK((is_above ? ratio.lower : ratio.upper) == Approx(is_above ? high : low).epsilon(1e-6));
  CHECK(std::isinf(is_above ? ratio.upper : ratio.lower));
  CHECK_THAT(ratio.note, Catch::Contains("beyond infinity"));
}
