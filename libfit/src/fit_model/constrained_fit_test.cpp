// SPDX-License-Identifier: MIT
#include "fit_model/constrained_fit.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fit_json.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

/// y = 1 + 2 x + 0.5 z with errors that are orthogonal to none of them.
data::Table plane() {
  std::vector<double> x;
  std::vector<double> z;
  std::vector<double> y;
  for (int i = 0; i < 12; ++i) {
    x.push_back(i);
    z.push_back((i * 5) % 7);
    y.push_back(1.0 + 2.0 * x.back() + 0.5 * z.back() + ((i * 3) % 5 - 2.0) * 0.1);
  }
  data::Table table;
  table.set("x", x);
  table.set("z", z);
  table.set("y", y);
  return table;
}

ModelSpecification plane_model(const data::Table& table) {
  return specify_model("y ~ a + b*x", {"b ~ 1", "a ~ 1 + z"}, table);
}

/// Two exponentials of six groups: the same curve with the pairs exchanged, two maxima with a
/// random effect in one of them.
data::Table two_exponentials() {
  Random random(1);
  std::vector<double> t;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 6; ++g) {
    const double amplitude = 3.0 + 0.6 * random.normal();
    for (int i = 0; i < 12; ++i) {
      t.push_back(0.25 * (i + 1));
      y.push_back(amplitude * std::exp(-0.5 * t.back()) + 1.5 * std::exp(-4.0 * t.back()) +
                  0.05 * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  data::Table table;
  table.set("g", group);
  table.set("t", t);
  table.set("y", y);
  return table;
}

}  // namespace

TEST_CASE("with a held coefficient the others are least-squares estimates") {
  const data::Table table = plane();
  const FitModelOptions options{.fixed = {{"a:z", 0.4}}};
  const FittedModel fit = fit_model(plane_model(table), table, options).fit;
  REQUIRE(fit.coefficient_names == std::vector<std::string>{"a", "a:z", "b"});
  CHECK(fit.estimate[1] == 0.4);
  CHECK(std::isnan(fit.standard_errors()[1]));
  CHECK(fit.parameter_count == 3);

  // The regression of y - 0.4 z on 1 and x.
  Eigen::MatrixXd design(12, 2);
  Eigen::VectorXd rest(12);
  for (Eigen::Index i = 0; i < 12; ++i) {
    const auto row = static_cast<std::size_t>(i);
    design.row(i) << 1.0, table.numbers("x")[row];
    rest[i] = table.numbers("y")[row] - 0.4 * table.numbers("z")[row];
  }
  const Eigen::Matrix2d inverse = (design.transpose() * design).inverse();
  const Eigen::Vector2d expected = inverse * (design.transpose() * rest);
  CHECK(fit.estimate[0] == Approx(expected[0]).epsilon(1e-12));
  CHECK(fit.estimate[2] == Approx(expected[1]).epsilon(1e-12));
  const double sigma2 = (rest - design * expected).squaredNorm() / 10.0;
  CHECK(fit.standard_errors()[2] == Approx(std::sqrt(sigma2 * inverse(1, 1))).epsilon(1e-10));
}

TEST_CASE("an intercept can be held while its covariates are estimated") {
  const data::Table table = plane();
  const FittedModel held = fit_model(plane_model(table), table, {.fixed = {{"a", 1.0}}}).fit;
  const ModelSpecification same = specify_model("y ~ 1 + c*z + b*x", {}, table);
  const FittedModel expected = fit_model(same, table).fit;
  CHECK(held.log_likelihood == Approx(expected.log_likelihood).epsilon(1e-12));
  CHECK(held.estimate[1] == Approx(expected.estimate[0]).epsilon(1e-12));
}

TEST_CASE("a coefficient that would cross its bound is held there and named") {
  const data::Table table = plane();
  const ModelSpecification model = plane_model(table);
  const FittedModel free = fit_model(model, table).fit;
  const FittedModel loose = fit_model(model, table, {.bounds = {{"b", {0.0, 5.0}}}}).fit;
  CHECK(loose.log_likelihood == free.log_likelihood);
  CHECK(!loose.convergence.has_boundary());

  const FittedModel tight = fit_model(model, table, {.bounds = {{"b", {0.0, 1.5}}}}).fit;
  const FittedModel held = fit_model(model, table, {.fixed = {{"b", 1.5}}}).fit;
  CHECK(tight.estimate[2] == 1.5);
  CHECK(tight.log_likelihood == held.log_likelihood);
  CHECK(tight.parameter_count == held.parameter_count + 1);
  REQUIRE(tight.convergence.boundary().size() == 1);
  CHECK(tight.convergence.boundary()[0] == "b = 1.5, its upper bound");
  CHECK_THAT(tight.convergence.verdict(), Contains("At its bound") && Contains("b = 1.5"));
}

TEST_CASE("only active bounds have an effect") {
  // Without bounds both slopes are outside; with b at its bound, the slope of z is inside.
  const data::Table table = plane();
  const FitModelOptions options{.bounds = {{"b", {2.2, 3.0}}, {"a:z", {-1.0, 0.45}}}};
  const FittedModel fit = fit_model(plane_model(table), table, options).fit;
  CHECK(fit.estimate[2] == 2.2);
  // The optimum satisfies Kuhn and Tucker's conditions: whatever is inside has no slope.
  for (const double slope : {0.35, 0.40, 0.44, 0.45}) {
    const FittedModel other =
        fit_model(plane_model(table), table, {.fixed = {{"b", 2.2}, {"a:z", slope}}}).fit;
    CHECK(other.log_likelihood <= fit.log_likelihood + 1e-9);
  }
}

TEST_CASE("if all coefficients are at bounds, only the variance is estimated") {
  // y - 1.1 - 2.2 x - 0.6 z needs less of everything.
  const data::Table table = plane();
  const ModelSpecification model = plane_model(table);
  const std::map<std::string, Bounds> bounds{
      {"a", {1.1, 3.0}}, {"a:z", {0.6, 3.0}}, {"b", {2.2, 3.0}}};
  double squares = 0.0;
  for (std::size_t i = 0; i < 12; ++i) {
    const double fitted = 1.1 + 2.2 * table.numbers("x")[i] + 0.6 * table.numbers("z")[i];
    squares += std::pow(table.numbers("y")[i] - fitted, 2);
  }
  const double expected = -6.0 * (std::log(2.0 * std::numbers::pi * squares / 12.0) + 1.0);
  for (const Method method : {Method::kOrdinary, Method::kGeneralized}) {
    const FittedModel fit = fit_model(model, table, {.method = method, .bounds = bounds}).fit;
    REQUIRE(fit.convergence.converged());
    CHECK(fit.estimate == Eigen::Vector3d(1.1, 0.6, 2.2));
    CHECK(fit.log_likelihood == Approx(expected).epsilon(1e-12));
    CHECK(fit.sigma == Approx(std::sqrt(squares / 12.0)).epsilon(1e-12));
    CHECK(fit.parameter_count == 4);
    CHECK(fit.convergence.boundary().size() == 3);
  }
}

TEST_CASE("impossible constraints are refused") {
  const data::Table table = plane();
  const ModelSpecification model = plane_model(table);
  CHECK_THROWS_WITH(fit_model(model, table, {.fixed = {{"q", 1.0}}}),
                    Contains("unknown coefficient"));
  CHECK_THROWS_WITH(fit_model(model, table, {.fixed = {{"a", 1.0}, {"a:z", 1.0}, {"b", 1.0}}}),
                    Contains("at least one must be estimated"));
  CHECK_THROWS_WITH(fit_model(model, table, {.bounds = {{"b", {2.0, 1.0}}}}),
                    Contains("must be below its upper bound"));
  CHECK_THROWS_WITH(fit_model(model, table, {.fixed = {{"b", 1.0}}, .bounds = {{"b", {0.0, 1.0}}}}),
                    Contains("both fixed and bounded"));
}

TEST_CASE("other maxima of a fit with held coefficients have the values of all coefficients") {
  const data::Table table = two_exponentials();
  ModelSpecification model = specify_model("y ~ c + A*exp(-k*t) + B*exp(-m*t)", {}, table);
  add_random_effects(model, "A | g", table);
  const std::vector<FitModelOptions> constraints{
      {.fixed = {{"c", 0.0}}}, {.bounds = {{"c", {0.02, 0.05}}}}, {.bounds = {{"m", {0.0, 3.0}}}}};
  for (const FitModelOptions& options : constraints) {
    const FittedModel fit = fit_model(model, table, options).fit;
    REQUIRE(fit.coefficient_names.size() == 5);
    REQUIRE(!fit.optima.empty());
    CHECK(fit.optima.front().estimate == fit.estimate);
    for (const LocalOptimum& optimum : fit.optima) {
      REQUIRE(optimum.estimate.size() == 5);
      for (Eigen::Index j = 0; j < 5; ++j) {
        // A coefficient without a standard error was held.
        if (std::isnan(fit.standard_errors()[j])) CHECK(optimum.estimate[j] == fit.estimate[j]);
      }
    }
    const FittedModel read = from_json(to_json(fit), "fit.json");
    REQUIRE(read.optima.size() == fit.optima.size());
    for (std::size_t k = 0; k < read.optima.size(); ++k) {
      CHECK(read.optima[k].estimate == fit.optima[k].estimate);
    }
  }
}
