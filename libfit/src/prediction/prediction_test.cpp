// SPDX-License-Identifier: MIT
#include "silvafit/fit/prediction.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "test_support/known_fit.hpp"
#include "test_support/saturating_curve.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

/// h ~ 1.3 + a*dbh^b with a = 1.5 + 0.4 C + u and b = 0.7; u is 0.2 in plot 07 and -0.1 in plot 8.
FittedModel power_curve() {
  FittedModel fit({.formula = data::parse_formula("h ~ 1.3 + a*dbh^b")});
  fit.specification.parameters = {parse_parameter_model("a ~ 1 + C"),
                                  parse_parameter_model("b ~ 1")};
  fit.specification.random = parse_random_effects("a | plot");
  fit.coefficient_names = {"a", "a:C", "b"};
  fit.estimate = Eigen::Vector3d(1.5, 0.4, 0.7);
  fit.random = {{.names = {"a"}, .labels = {"07", "8"}, .effects = Eigen::RowVector2d(0.2, -0.1)}};
  fit.sigma = 0.5;
  fit.variance = VarianceEstimate::missing(parse_variance_function("power"));
  fit.variance.factors[0].delta[0] = 2.0;
  return fit;
}

data::Table trees() {
  data::Table table;
  table.set("dbh", std::vector<double>{10.0, 20.0, kNaN, 30.0, 40.0});
  table.set("C", std::vector<double>{0.25, 0.5, 0.5, 1.0, kNaN});
  data::TextColumn plot;
  for (const char* label : {"07", "8", "8", "9", "07"}) plot.append(label);
  table.set("plot", plot);
  return table;
}

double height(double a, double dbh) { return 1.3 + a * std::pow(dbh, 0.7); }

}  // namespace

TEST_CASE("the population's prediction is the formula with the fixed effects") {
  const Prediction prediction = predict(power_curve(), trees(), Level::kPopulation);
  CHECK(prediction.value[0] == Approx(height(1.6, 10.0)).epsilon(1e-14));
  CHECK(prediction.value[1] == Approx(height(1.7, 20.0)).epsilon(1e-14));
  CHECK(prediction.value[3] == Approx(height(1.9, 30.0)).epsilon(1e-14));
  CHECK(std::isnan(prediction.value[2]));
  CHECK(std::isnan(prediction.value[4]));
  CHECK(prediction.residual_sd[0] == Approx(0.5 * std::pow(height(1.6, 10.0), 2.0)).epsilon(1e-14));
  CHECK(std::isnan(prediction.residual_sd[2]));
  CHECK(prediction.unknown_terms == std::vector<unsigned>(5, 0));
}

TEST_CASE("the conditional prediction adds the effects of the row's group") {
  const Prediction prediction = predict(power_curve(), trees(), Level::kConditional);
  CHECK(prediction.value[0] == Approx(height(1.8, 10.0)).epsilon(1e-14));
  CHECK(prediction.value[1] == Approx(height(1.6, 20.0)).epsilon(1e-14));
  CHECK(prediction.value[3] == Approx(height(1.9, 30.0)).epsilon(1e-14));
  CHECK(prediction.unknown_terms == std::vector<unsigned>{0, 0, 0, 1, 0});
}

TEST_CASE("the prediction of new groups is an explicit choice") {
  const Prediction missing =
      predict(power_curve(), trees(), Level::kConditional, {.new_groups = NewGroups::kMissing});
  CHECK(std::isnan(missing.value[3]));
  CHECK(std::isfinite(missing.value[1]));
  data::Table table = trees();
  table.set_origin("new.csv", {2, 3, 4, 5, 6});
  CHECK_THROWS_WITH(
      predict(power_curve(), table, Level::kConditional, {.new_groups = NewGroups::kError}),
      Contains("new.csv:5: plot: unknown group '9'"));
}

TEST_CASE("without random effects both levels are the same") {
  FittedModel fit = power_curve();
  fit.specification.random.clear();
  fit.random.clear();
  const Prediction prediction = predict(fit, trees(), Level::kConditional);
  CHECK(prediction.value[0] == Approx(height(1.6, 10.0)).epsilon(1e-14));
}

TEST_CASE("a level that is not in the fit has no prediction") {
  data::Table table(4);
  table.set("y", std::vector<double>{10, 20, 12, 22});
  data::TextColumn kind;
  for (const char* label : {"fir", "oak", "fir", "oak"}) kind.append(label);
  table.set("kind", kind);
  table.set("zone", std::vector<double>{1, 1, 2, 2});
  data::Table there(4);
  data::TextColumn other;
  for (const char* label : {"oak", "ash", "fir", "fir"}) other.append(label);
  there.set("kind", other);
  there.set("zone", std::vector<double>{2, 1, 3, 1});
  for (const char* terms : {"kind + factor(zone)", "0 + kind + factor(zone)"}) {
    const FittedModel fit =
        fit_model(specify_model("y ~ a", {std::string("a ~ ") + terms}, table), table).fit;
    const Prediction prediction = predict(fit, there, Level::kPopulation, {.interval = 0.9});
    CHECK(prediction.value[0] == Approx(22.0).epsilon(1e-12));
    CHECK(std::isnan(prediction.value[1]));
    CHECK(std::isnan(prediction.value[2]));
    CHECK(std::isnan(prediction.lower[2]));
    CHECK(prediction.value[3] == Approx(10.0).epsilon(1e-12));
  }
  // A comparison has a value for every label.
  const FittedModel compared =
      fit_model(specify_model("y ~ a", {"a ~ (kind == \"oak\")"}, table), table).fit;
  CHECK(predict(compared, there, Level::kPopulation).value[1] == Approx(11.0).epsilon(1e-12));
}

TEST_CASE("the variance may follow a column") {
  FittedModel fit = power_curve();
  fit.variance.factors[0].factor.column = "dbh";
  const Prediction prediction = predict(fit, trees(), Level::kPopulation);
  CHECK(prediction.residual_sd[1] == Approx(0.5 * 400.0).epsilon(1e-14));
}

TEST_CASE("a missing value gives a missing prediction for any formula") {
  FittedModel fit = power_curve();
  fit.specification.formula = data::parse_formula("h ~ a*b*ifelse(dbh > 5, 2, 3)");
  CHECK(std::isnan(predict(fit, trees(), Level::kPopulation).value[2]));
}

TEST_CASE("nested groups have the known effects of both groupings") {
  FittedModel fit = power_curve();
  fit.specification.random = parse_random_effects("b | stand; a | plot");
  fit.random.insert(
      fit.random.begin(),
      {.names = {"b"}, .labels = {"S", "T"}, .effects = Eigen::RowVector2d(0.05, -0.02)});
  fit.random.back().labels = {"S/07", "T/8"};
  data::Table table = trees();
  data::TextColumn stand;
  for (const char* label : {"S", "T", "T", "S", "S"}) stand.append(label);
  table.set("stand", stand);
  const Prediction prediction = predict(fit, table, Level::kConditional);
  const auto curve = [](double a, double b, double dbh) { return 1.3 + a * std::pow(dbh, b); };
  CHECK(prediction.value[0] == Approx(curve(1.5 + 0.4 * 0.25 + 0.2, 0.75, 10.0)).epsilon(1e-14));
  CHECK(prediction.value[1] == Approx(curve(1.5 + 0.4 * 0.5 - 0.1, 0.68, 20.0)).epsilon(1e-14));
  // Plot 9 is new, but its stand is known.
  CHECK(prediction.unknown_terms[3] == 2);
  CHECK(prediction.value[3] == Approx(curve(1.5 + 0.4, 0.75, 30.0)).epsilon(1e-14));
}

TEST_CASE("effects of a coarser group are found in spite of a slash in its label") {
  FittedModel fit = model("y ~ a + 0*x", {"a"}, "a | stand; a | plot");
  fit.estimate = Eigen::VectorXd::Constant(1, 10.0);
  fit.random.front().labels = {"S", "S/1"};
  fit.random.front().effects = Eigen::RowVector2d(1.0, 2.0);
  fit.random.back().labels = {nested_label("S", "1/1"), nested_label("S/1", "1")};
  fit.random.back().effects = Eigen::RowVector2d(0.1, 0.2);
  data::Table table;
  table.set("x", std::vector<double>{0.0, 0.0});
  table.set("stand", texts({"S", "S/1"}));
  table.set("plot", texts({"1/1", "1"}));
  const Prediction prediction = predict(fit, table, Level::kConditional);
  CHECK(prediction.value[0] == Approx(11.1).epsilon(1e-15));
  CHECK(prediction.value[1] == Approx(12.2).epsilon(1e-15));
}

TEST_CASE("predictions do not need columns that only the variance function reads") {
  FittedModel fit = power_curve();
  fit.degrees_of_freedom = Eigen::Vector3d::Constant(50.0);
  fit.covariance = Eigen::Vector3d(0.01, 0.01, 1e-4).asDiagonal();
  fit.random.back().covariance = Eigen::MatrixXd::Constant(1, 1, 0.02);
  SECTION("a missing column") {
    fit.variance.factors[0].factor.column = "noise";
    const Prediction prediction = predict(fit, trees(), Level::kPopulation, {.interval = 0.95});
    CHECK(prediction.value[1] == Approx(height(1.7, 20.0)).epsilon(1e-14));
    CHECK(prediction.residual_sd.array().isNaN().all());
    CHECK(prediction.lower.array().isNaN().all());
    CHECK(prediction.upper.array().isNaN().all());
    CHECK(prediction.residual_gap == std::vector<std::string>(5, "missing noise"));
    // The mean still has its interval.
    const Prediction mean = predict(fit,
                                    trees(),
                                    Level::kPopulation,
                                    {.interval = 0.95, .interval_kind = IntervalKind::kConfidence});
    CHECK(mean.lower[1] < mean.value[1]);
    CHECK(mean.value[1] < mean.upper[1]);
  }
  SECTION("a stratum that is not in the fit, or none") {
    fit.variance = VarianceEstimate::missing(parse_variance_function("stratum(species)"));
    fit.variance.factors[0].strata = {"fir", "oak"};
    fit.variance.factors[0].ratio = Eigen::Vector2d(1.0, 1.6);
    data::Table table = trees();
    data::TextColumn species;
    for (const char* label : {"fir", "elm", "oak", "oak"}) species.append(label);
    species.append_missing();
    table.set("species", species);
    const Prediction prediction = predict(fit, table, Level::kPopulation, {.interval = 0.95});
    CHECK(prediction.residual_gap ==
          std::vector<std::string>{"", "unknown species", "", "", "missing species"});
    CHECK(std::isfinite(prediction.value[1]));
    CHECK(std::isnan(prediction.lower[1]));
    CHECK(prediction.lower[0] < prediction.upper[0]);
    CHECK(prediction.residual_sd[3] == Approx(0.5 * 1.6));
  }
}

TEST_CASE("confidence limits of a mean along a ridge are t standard errors away") {
  const data::Table table = saturating();
  const FittedModel fit =
      fit_model(specify_model({.formula = "y ~ A*(1 - exp(-k*x))"}, table), table).fit;
  data::Table at;
  at.set("x", std::vector<double>{5.0, 8.0, 10.0});
  const Prediction found = predict(
      fit, at, Level::kPopulation, {.interval = 0.95, .interval_kind = IntervalKind::kConfidence});
  // By scipy: the gradient at the estimates with their covariance; the digits of a fit.
  const Eigen::Vector3d lower(6.5008441449849395, 9.34720234988643, 10.588240599510895);
  const Eigen::Vector3d upper(7.176116401193728, 10.050836770653007, 11.858987307601234);
  // The limits of the profile likelihood, for which 3 % of the width are a share of coverage of
  // about 0.2 %.
  const Eigen::Vector3d profile_lower(6.498444195996576, 9.346413922771392, 10.600606531926353);
  const Eigen::Vector3d profile_upper(7.17432773856094, 10.050335171379974, 11.87303039192891);
  for (Eigen::Index i = 0; i < 3; ++i) {
    CHECK(found.lower[i] == Approx(lower[i]).epsilon(1e-7));
    CHECK(found.upper[i] == Approx(upper[i]).epsilon(1e-7));
    const double width = upper[i] - lower[i];
    CHECK(found.lower[i] == Approx(profile_lower[i]).margin(0.03 * width));
    CHECK(found.upper[i] == Approx(profile_upper[i]).margin(0.03 * width));
  }
}

TEST_CASE("a mean of one linear combination has the limits of that combination") {
  // h/(1 + exp(a + b x)) at x = 3 depends on a + 3 b, whose variance is 4 + 6 (-1) + 9 (0.5).
  FittedModel fit({.formula = data::parse_formula("y ~ 20/(1 + exp(a + b*x))")});
  fit.specification.parameters = {parse_parameter_model("a ~ 1"), parse_parameter_model("b ~ 1")};
  fit.coefficient_names = {"a", "b"};
  fit.estimate = Eigen::Vector2d(0.3, -0.2);
  fit.covariance = (Eigen::Matrix2d() << 4.0, -1.0, -1.0, 0.5).finished();
  fit.degrees_of_freedom = Eigen::Vector2d(28.0, 28.0);
  fit.observations = 30;
  fit.sigma = 0.5;
  data::Table at;
  at.set("x", std::vector<double>{3.0});
  const Prediction found = predict(
      fit, at, Level::kPopulation, {.interval = 0.95, .interval_kind = IntervalKind::kConfidence});
  const double reach = boost::math::quantile(boost::math::students_t(28.0), 0.975) * std::sqrt(2.5);
  CHECK(found.lower[0] == Approx(20.0 / (1.0 + std::exp(-0.3 + reach))).epsilon(1e-12));
  CHECK(found.upper[0] == Approx(20.0 / (1.0 + std::exp(-0.3 - reach))).epsilon(1e-12));
}
