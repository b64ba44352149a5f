// SPDX-License-Identifier: MIT
#include "silvafit/data/program.hpp"

#include <ceres/jet.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using silvafit::kNaN;
using silvafit::Random;
using silvafit::data::Expression;
using silvafit::data::Program;
using silvafit::data::Table;
using silvafit::data::TextColumn;

namespace {

// First derivatives of first derivatives: second derivatives without our rules.
using Inner = ceres::Jet<double, 3>;
using Outer = ceres::Jet<Inner, 3>;

Outer argument(double value, int index) {
  Outer result;
  result.a = Inner(value, index);
  result.v.setConstant(Inner(0.0));
  result.v[index] = Inner(1.0);
  return result;
}

struct Curve {
  const char* text;
  Outer (*function)(const Outer& a, const Outer& b, const Outer& c, double x);
};

const std::vector<Curve> kCurves = {
    {"1.3 + a*(1 - exp(-b*x))^c",
     [](const Outer& a, const Outer& b, const Outer& c, double x) {
       return Outer(Inner(1.3)) + a * pow(Outer(Inner(1.0)) - exp(-b * Outer(Inner(x))), c);
     }},
    {"a/(1 + b*exp(-c*x))",
     [](const Outer& a, const Outer& b, const Outer& c, double x) {
       return a / (Outer(Inner(1.0)) + b * exp(-c * Outer(Inner(x))));
     }},
    {"x^2/(a*x^2 + b*x + c)",
     [](const Outer& a, const Outer& b, const Outer& c, double x) {
       return Outer(Inner(x * x)) / (a * Outer(Inner(x * x)) + b * Outer(Inner(x)) + c);
     }},
};

}  // namespace

TEST_CASE("blocks of values and both derivatives equal nested dual numbers") {
  const std::vector<std::string> parameters{"a", "b", "c"};
  Random random(3);
  std::vector<double> x(1000);  // several blocks and a rest
  for (double& value : x) value = random.uniform(0.5, 60.0);
  const std::vector<double> at{25.0, 0.05, 1.3};

  for (const Curve& curve : kCurves) {
    const Expression f = Expression::parse(curve.text);
    std::vector<Expression> outputs{f};
    for (const auto& p : parameters) outputs.push_back(f.derivative(p));
    for (const auto& p : parameters) {
      for (const auto& q : parameters) outputs.push_back(f.derivative(p).derivative(q));
    }
    const Program program(outputs, {{"a", true}, {"b", true}, {"c", true}, {"x", false}});
    std::vector<std::vector<double>> results(outputs.size(), std::vector<double>(x.size()));
    std::vector<double*> targets;
    targets.reserve(results.size());
    for (auto& result : results) targets.push_back(result.data());
    const std::vector<const double*> inputs{&at[0], &at[1], &at[2], x.data()};
    Program::Workspace workspace;
    program.evaluate(inputs, x.size(), targets, workspace);

    for (std::size_t i = 0; i < x.size(); ++i) {
      const Outer expected =
          curve.function(argument(at[0], 0), argument(at[1], 1), argument(at[2], 2), x[i]);
      CAPTURE(curve.text, x[i]);
      // A dozen operations of rounding each way, relative to the largest term that enters.
      REQUIRE(results[0][i] == Approx(expected.a.a).epsilon(1e-13));
      for (int p = 0; p < 3; ++p) {
        REQUIRE(results[1 + p][i] == Approx(expected.v[p].a).epsilon(1e-12).margin(1e-14));
        for (int q = 0; q < 3; ++q) {
          REQUIRE(results[4 + 3 * p + q][i] ==
                  Approx(expected.v[p].v[q]).epsilon(1e-12).margin(1e-11));
        }
      }
    }
  }
}

TEST_CASE("parameters may differ by row") {
  const std::vector<Expression> outputs{Expression::parse("a*x"), Expression::parse("a")};
  const Program program(outputs, {{"a", false}, {"x", true}});
  const std::vector<double> a{1.0, 2.0, 3.0};
  const double x = 10.0;
  std::vector<double> product(3);
  std::vector<double> copy(3);
  const std::vector<const double*> inputs{a.data(), &x};
  const std::vector<double*> targets{product.data(), copy.data()};
  Program::Workspace workspace;
  program.evaluate(inputs, 3, targets, workspace);
  CHECK(product == std::vector<double>{10.0, 20.0, 30.0});
  CHECK(copy == a);
}

TEST_CASE("a block gives what single values give, for every operation") {
  const std::vector<std::string> names{"x", "y", "s"};
  const std::vector<double> x{-2.0, -0.5, 0.0, 0.25, 0.9, 3.0};
  const std::vector<double> y{0.5, -1.0, 2.0, 0.0, 0.3, -2.0};
  const double s = 1.5;
  for (const char* text : {"x + s",      "s - x",
                           "x*y",        "s/y",
                           "x^y",        "x^2",
                           "x^3",        "x^(-2)",
                           "y^s",        "s^x",
                           "-x",         "exp(x)",
                           "log(x)",     "log10(x)",
                           "log2(x)",    "log1p(x)",
                           "expm1(x)",   "sqrt(x)",
                           "abs(x)",     "sign(x)",
                           "sin(x)",     "cos(x)",
                           "tan(x)",     "asin(x)",
                           "acos(x)",    "atan(x)",
                           "sinh(x)",    "cosh(x)",
                           "tanh(x)",    "min(x, y)",
                           "max(x,s)",   "x < y",
                           "x <= 0.25",  "x == 0.9",
                           "x > 0 && y", "x || y",
                           "!x",         "ifelse(x < y, x, s)",
                           "x*0 + 7"}) {
    const Expression expression = Expression::parse(text);
    const Program program(std::vector<Expression>{expression}, {{"x"}, {"y"}, {"s", true}});
    std::vector<double> result(x.size());
    double* target = result.data();
    const std::vector<const double*> inputs{x.data(), y.data(), &s};
    Program::Workspace workspace;
    program.evaluate(inputs, x.size(), std::span(&target, 1), workspace);
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double expected = expression.value(names, {x[i], y[i], s});
      CAPTURE(text, x[i], y[i]);
      if (std::isnan(expected)) {
        CHECK(std::isnan(result[i]));
      } else {
        CHECK(result[i] == Approx(expected).epsilon(4e-15));
      }
    }
  }
}

TEST_CASE("blocks of slopes at the edge of a domain are those of single values") {
  const std::vector<std::string> names{"x", "m", "s"};
  const std::vector<double> x{0.0, 2.0, 0.0, 1e-3, 40.0};
  const double m = 1.0;
  const double s = 0.25;
  for (const char* const formula : {"1/(1 + exp((m - log(x))/s))", "1/(1 + (x/m)^s)"}) {
    INFO(formula);
    const Expression mean = Expression::parse(formula).with_limits();
    const Expression slope = mean.derivative("s");
    const Expression third = slope.derivative("m").derivative("m");
    const Program program(std::vector<Expression>{slope, third}, {{"x"}, {"m", true}, {"s", true}});
    std::vector<double> slopes(x.size());
    std::vector<double> thirds(x.size());
    const std::vector<double*> targets{slopes.data(), thirds.data()};
    const std::vector<const double*> inputs{x.data(), &m, &s};
    Program::Workspace workspace;
    program.evaluate(inputs, x.size(), targets, workspace);
    for (std::size_t i = 0; i < x.size(); ++i) {
      // A few units in the last place of exponents near 30, and of sums of terms of both signs.
      CHECK(slopes[i] == Approx(slope.value(names, {x[i], m, s})).epsilon(1e-13));
      CHECK(thirds[i] == Approx(third.value(names, {x[i], m, s})).epsilon(1e-11));
    }
    CHECK(slopes[0] == 0.0);
    CHECK(thirds[0] == 0.0);
  }
}

TEST_CASE("an expression of a table's columns compares text") {
  Table table;
  table.set("dbh", {10.0, 20.0, 30.0, 40.0});
  TextColumn species;
  species.append("SM");
  species.append("MH");
  species.append("SM");
  species.append_missing();
  table.set("species", species);
  const auto values =
      silvafit::data::evaluate(Expression::parse("species == \"SM\" && dbh > 15"), table);
  CHECK(std::vector(values.begin(), values.end() - 1) == std::vector<double>{0.0, 0.0, 1.0});
  CHECK(std::isnan(values[3]));
  CHECK_THROWS_AS(silvafit::data::evaluate(Expression::parse("height"), table),
                  silvafit::UsageError);
}

TEST_CASE("text is compared with numbers by their value") {
  Table table;
  table.set("plot", {1.0, 100000.0, NAN});
  const auto holds = [&](const char* text) {
    return silvafit::data::evaluate(Expression::parse(text), table);
  };
  CHECK(holds("plot == \"01\"")[0] == 1.0);
  CHECK(holds("plot == \"01\"")[1] == 0.0);
  CHECK(holds("plot != \"100000\"")[1] == 0.0);
  CHECK(holds("plot == \"one\"")[0] == 0.0);
  CHECK(std::isnan(holds("plot != \"01\"")[2]));
}

TEST_CASE("the result of a missing condition is missing") {
  // Kleene's three-valued logic; R's <, ==, &, |, ! and ifelse give the same.
  const std::pair<const char*, double> cases[] = {{"m < 1", kNaN},
                                                  {"1 <= m", kNaN},
                                                  {"m == m", kNaN},
                                                  {"m != 1", kNaN},
                                                  {"!m", kNaN},
                                                  {"!(m < 2)", kNaN},
                                                  {"m && one", kNaN},
                                                  {"m && zero", 0.0},
                                                  {"zero && m", 0.0},
                                                  {"m || zero", kNaN},
                                                  {"m || one", 1.0},
                                                  {"one || m", 1.0},
                                                  {"one && zero", 0.0},
                                                  {"one && one", 1.0},
                                                  {"zero || zero", 0.0},
                                                  {"ifelse(m, 3, 4)", kNaN},
                                                  {"ifelse(zero, m, 4)", 4.0}};
  Table table;
  table.set("m", std::vector<double>(9, kNaN));
  table.set("one", std::vector<double>(9, 1.0));
  table.set("zero", std::vector<double>(9, 0.0));
  for (const auto& [text, expected] : cases) {
    CAPTURE(text);
    const Expression expression = Expression::parse(text);
    const double alone = expression.value({"m", "one", "zero"}, {kNaN, 1.0, 0.0});
    for (const double value : silvafit::data::evaluate(expression, table)) {
      CHECK(std::isnan(value) == std::isnan(expected));
      if (!std::isnan(expected)) CHECK(value == expected);
    }
    CHECK(std::isnan(alone) == std::isnan(expected));
    if (!std::isnan(expected)) CHECK(alone == expected);
  }
}

TEST_CASE("a variable that is no input is named") {
  CHECK_THROWS_WITH(
      Program(std::vector<Expression>{Expression::parse("a*dhb")}, {{"a", true}, {"dbh"}}),
      Catch::Matchers::Contains("'dhb'"));
}
