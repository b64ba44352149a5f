// SPDX-License-Identifier: MIT
// How far programs are from functions with more digits, over wide ranges and at special values.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "program/each_instruction_set_test_support.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/program.hpp"

using silvafit::kInfinity;
using silvafit::Random;
using silvafit::data::Expression;
using silvafit::data::Program;
using silvafit::data::with_each_instruction_set;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr double kNormal = std::numeric_limits<double>::min();
constexpr double kLargest = std::numeric_limits<double>::max();

std::vector<double> evaluated(const Expression& expression,
                              const std::vector<double>& x,
                              const std::vector<double>& y) {
  const Program program(std::vector<Expression>{expression}, {{"x"}, {"y"}});
  std::vector<double> result(x.size());
  double* target = result.data();
  const std::vector<const double*> inputs{x.data(), y.data()};
  Program::Workspace workspace;
  program.evaluate(inputs, x.size(), std::span(&target, 1), workspace);
  return result;
}

/// The distance in units of the last place of the nearest double.
double error_in_ulp(double value, long double exact) {
  const double nearest = static_cast<double>(exact);
  if (std::isnan(nearest)) return std::isnan(value) ? 0.0 : kInfinity;
  if (value == nearest) return 0.0;
  if (!std::isfinite(nearest) || !std::isfinite(value)) return kInfinity;
  const double size = std::max(std::abs(nearest), kNormal);
  const double ulp = std::nextafter(size, kInfinity) - size;
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact)) / ulp;
}

struct Range {
  double from;
  double to;
};

struct Case {
  const char* text;
  long double (*exact)(long double);
  double bound_ulp;  ///< at least a tenth above the largest error measured with any instruction set
  std::vector<Range> ranges;
};

/// Evenly spread over a range, and over its powers of ten towards zero.
std::vector<double> arguments(const std::vector<Range>& ranges, std::size_t count) {
  Random random(11);
  std::vector<double> x;
  for (const Range& range : ranges) {
    for (std::size_t i = 0; i < count; ++i) {
      const double value = random.uniform(range.from, range.to);
      x.push_back(value);
      if (range.from <= 0.0 && range.to >= 0.0) {
        x.push_back(value * std::pow(10.0, -random.uniform(0.0, 20.0)));
      }
    }
  }
  return x;
}

// Over all sizes of positive numbers.
std::vector<double> all_sizes(std::size_t count) {
  Random random(12);
  std::vector<double> x;
  for (std::size_t i = 0; i < count; ++i) {
    x.push_back(
        std::ldexp(random.uniform(1.0, 2.0), static_cast<int>(random.uniform(-1074.0, 1023.9))));
    x.push_back(1.0 + random.uniform(-1.0, 1.0) * std::pow(10.0, -random.uniform(0.0, 16.0)));
  }
  return x;
}

const std::vector<double> kSpecial = {
    0.0,      -0.0,     1.0,       -1.0,  kInfinity, -kInfinity, kNan,  kTiny,  -kTiny, kNormal,
    -kNormal, kLargest, -kLargest, 800.0, -800.0,    709.7,      709.8, -745.0, -746.0, 1e-300,
    0.5,      -0.5,     2.0,       1e5,   -1e5,      1e22,       1e-9,  -1e-9,  708.5,  -708.5};

}  // namespace

TEST_CASE("functions are right to a few units in the last place") {
  // The exact values are those of the C library for 64 bits, whose own error is below 2^-10 of our
  // unit.
  const std::vector<Case> cases = {
      {"exp(x)", [](long double x) { return std::exp(x); }, 1.25, {{-1.0, 1.0}, {-744.0, 709.7}}},
      {"expm1(x)", [](long double x) { return std::expm1(x); }, 2.0, {{-1.0, 1.0}, {-50.0, 709.0}}},
      {"log1p(x)", [](long double x) { return std::log1p(x); }, 1.75, {{-1.0, 1.0}, {0.0, 1e6}}},
      {"sin(x)", [](long double x) { return std::sin(x); }, 3.0, {{-4.0, 4.0}, {-1e5, 1e5}}},
      {"cos(x)", [](long double x) { return std::cos(x); }, 3.0, {{-4.0, 4.0}, {-1e5, 1e5}}},
      {"tan(x)", [](long double x) { return std::tan(x); }, 4.0, {{-4.0, 4.0}, {-1e5, 1e5}}},
      {"asin(x)", [](long double x) { return std::asin(x); }, 2.75, {{-1.0, 1.0}}},
      {"acos(x)", [](long double x) { return std::acos(x); }, 1.5, {{-1.0, 1.0}}},
      {"atan(x)", [](long double x) { return std::atan(x); }, 2.25, {{-2.0, 2.0}, {-1e4, 1e4}}},
      {"sinh(x)", [](long double x) { return std::sinh(x); }, 2.5, {{-1.0, 1.0}, {-709.0, 709.0}}},
      {"cosh(x)", [](long double x) { return std::cosh(x); }, 1.25, {{-1.0, 1.0}, {-709.0, 709.0}}},
      {"tanh(x)", [](long double x) { return std::tanh(x); }, 2.75, {{-1.0, 1.0}, {-30.0, 30.0}}},
  };
  with_each_instruction_set([&](const std::string& set) {
    for (const Case& test : cases) {
      std::vector<double> x = arguments(test.ranges, 20000);
      const std::vector<double> values = evaluated(Expression::parse(test.text), x, x);
      double worst = 0.0;
      double worst_at = 0.0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        const double error = error_in_ulp(values[i], test.exact(x[i]));
        if (!(error <= worst)) {
          worst = error;
          worst_at = x[i];
        }
      }
      CAPTURE(set, test.text, worst_at, worst);
      CHECK(worst <= test.bound_ulp);
    }
  });
}

TEST_CASE("logarithms of all sizes are right to a unit in the last place") {
  const std::vector<double> x = all_sizes(40000);
  const auto worst = [&x](const char* text, long double (*exact)(long double)) {
    const std::vector<double> values = evaluated(Expression::parse(text), x, x);
    double result = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      result = std::max(result, error_in_ulp(values[i], exact(x[i])));
    }
    return result;
  };
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    CHECK(worst("log(x)", [](long double v) { return std::log(v); }) <= 1.0);
    CHECK(worst("log2(x)", [](long double v) { return std::log2(v); }) <= 0.55);
    CHECK(worst("log10(x)", [](long double v) { return std::log10(v); }) <= 0.55);
  });
}

TEST_CASE("powers are right to a few units in the last place, however large the exponent") {
  Random random(13);
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 100000; ++i) {
    // y log x up to 700, where an error of the logarithm counts 700 times.
    x.push_back(i % 2 == 0 ? std::pow(10.0, random.uniform(-8.0, 8.0)) : random.uniform(0.5, 2.0));
    y.push_back(random.uniform(-700.0, 700.0) / std::log(x.back()));
    if (i % 3 == 0) y.back() = random.uniform(-3.0, 3.0);
  }
  with_each_instruction_set([&](const std::string& set) {
    CAPTURE(set);
    const std::vector<double> values = evaluated(Expression::parse("x^y"), x, y);
    double worst = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      worst = std::max(
          worst,
          error_in_ulp(values[i],
                       std::pow(static_cast<long double>(x[i]), static_cast<long double>(y[i]))));
    }
    CHECK(worst <= 0.75);
  });
}

TEST_CASE("special values are those of the C library") {
  struct Special {
    const char* text;
    double (*expected)(double);
  };
  const std::vector<Special> functions = {
      {"exp(x)", [](double x) { return std::exp(x); }},
      {"log(x)", [](double x) { return std::log(x); }},
      {"log2(x)", [](double x) { return std::log2(x); }},
      {"log10(x)", [](double x) { return std::log10(x); }},
      {"log1p(x)", [](double x) { return std::log1p(x); }},
      {"expm1(x)", [](double x) { return std::expm1(x); }},
      {"sqrt(x)", [](double x) { return std::sqrt(x); }},
      {"sin(x)", [](double x) { return std::sin(x); }},
      {"cos(x)", [](double x) { return std::cos(x); }},
      {"tan(x)", [](double x) { return std::tan(x); }},
      {"asin(x)", [](double x) { return std::asin(x); }},
      {"acos(x)", [](double x) { return std::acos(x); }},
      {"atan(x)", [](double x) { return std::atan(x); }},
      {"sinh(x)", [](double x) { return std::sinh(x); }},
      {"cosh(x)", [](double x) { return std::cosh(x); }},
      {"tanh(x)", [](double x) { return std::tanh(x); }},
      {"abs(x)", [](double x) { return std::abs(x); }},
  };
  with_each_instruction_set([&](const std::string& set) {
    for (const Special& function : functions) {
      const std::vector<double> values =
          evaluated(Expression::parse(function.text), kSpecial, kSpecial);
      for (std::size_t i = 0; i < kSpecial.size(); ++i) {
        const double expected = function.expected(kSpecial[i]);
        CAPTURE(set, function.text, kSpecial[i], values[i], expected);
        CHECK(error_in_ulp(values[i], expected) <= 4.0);
        if (!std::isnan(expected)) CHECK(std::signbit(values[i]) == std::signbit(expected));
      }
    }
  });
}

TEST_CASE("operations on every pair of special values are those of single values") {
  std::vector<double> x;
  std::vector<double> y;
  for (const double a : kSpecial) {
    for (const double b : kSpecial) {
      x.push_back(a);
      y.push_back(b);
    }
  }
  const std::vector<std::string> names{"x", "y"};
  with_each_instruction_set([&](const std::string& set) {
    for (const char* text : {"x + y",
                             "x - y",
                             "x*y",
                             "x/y",
                             "x^y",
                             "x < y",
                             "x <= y",
                             "x == y",
                             "x != y",
                             "x > y",
                             "x && y",
                             "x || y",
                             "!x",
                             "min(x, y)",
                             "max(x, y)",
                             "sign(x)",
                             "-x",
                             "ifelse(x, y, 2)",
                             "ifelse(x < y, 1, y)",
                             "ifelse(1 < 2, x, y)",
                             "log_floored(x)",
                             "2^x",
                             "0.5^y",
                             "x^2.5"}) {
      const Expression expression = Expression::parse(text);
      const std::vector<double> values = evaluated(expression, x, y);
      for (std::size_t i = 0; i < x.size(); ++i) {
        const double expected = expression.value(names, {x[i], y[i]});
        CAPTURE(set, text, x[i], y[i], values[i], expected);
        // Single values use std::pow and std::log, right to one unit; ours to 1.5.
        REQUIRE(error_in_ulp(values[i], expected) <= 2.5);
        if (!std::isnan(expected)) REQUIRE(std::signbit(values[i]) == std::signbit(expected));
      }
    }
  });
}

TEST_CASE("a row's value depends on that row alone") {
  // Each of these takes another path for some of its rows.
  std::vector<double> x = kSpecial;
  for (int i = 0; i < 300; ++i) x.push_back(0.01 * i);
  std::vector<double> y(x.size(), 1.7);
  with_each_instruction_set([&](const std::string& set) {
    for (const char* text :
         {"exp(x)", "log(x)", "x^y", "log10(x)", "tanh(x)", "x*y + log(x)^2.5"}) {
      const Expression expression = Expression::parse(text);
      const std::vector<double> together = evaluated(expression, x, y);
      for (std::size_t i = 0; i < x.size(); ++i) {
        const std::vector<double> alone = evaluated(expression, {x[i]}, {y[i]});
        CAPTURE(set, text, x[i]);
        REQUIRE((std::isnan(alone[0]) ? std::isnan(together[i]) : alone[0] == together[i]));
      }
    }
  });
}

TEST_CASE("results are the same on all processors with fused multiply-add") {
  const std::vector<double> x = all_sizes(5000);
  const std::vector<double> y = arguments({{-20.0, 20.0}}, 5000);
  for (const char* text : {"exp(y)", "log(x)", "x^y", "1.3 + y*(1 - exp(-x))", "log10(x)*sin(y)"}) {
    std::vector<std::vector<double>> results;
    with_each_instruction_set([&](const std::string& set) {
      if (set == "AVX2" || set == "AVX3" || set == "NEON") {
        results.push_back(evaluated(Expression::parse(text), x, y));
      }
    });
    for (const auto& result : results) {
      CHECK(std::memcmp(result.data(), results[0].data(), result.size() * sizeof(double)) == 0);
    }
  }
}

TEST_CASE("scalars and columns may meet in every way, in any number of rows") {
  // What becomes one step, is moved to scalars, or shares a logarithm; some outputs are parts of
  // others, repeat another, or are an input.
  const std::vector<std::string> texts = {"x*y + s",
                                          "s - x*y",
                                          "x*y - s",
                                          "x*y + s*x",
                                          "x*y - s*y",
                                          "-(x*y)",
                                          "-(x/y)",
                                          "s*(2*(3*x))",
                                          "s*(2/x)",
                                          "exp(-x*y)",
                                          "exp(s*x) + x*y",
                                          "x^s",
                                          "x^(s + 1)",
                                          "x^s*log(x)",
                                          "log(x)",
                                          "x^y + y^x",
                                          "x^3",
                                          "x^(-2)",
                                          "ifelse(x < y, s, x)",
                                          "min(x, y)*s",
                                          "x*y",
                                          "x*y + s",
                                          "x",
                                          "s",
                                          "abs(x - y)",
                                          "1.3 + s*(1 - exp(-x*y))^s"};
  std::vector<Expression> outputs;
  outputs.reserve(texts.size());
  for (const std::string& text : texts) outputs.push_back(Expression::parse(text));
  Random random(17);
  const std::vector<std::string> names{"x", "y", "s"};
  with_each_instruction_set([&](const std::string& set) {
    for (int scalars = 0; scalars < 8; ++scalars) {
      std::vector<Program::Input> inputs;
      inputs.reserve(names.size());
      for (int k = 0; k < 3; ++k) inputs.push_back({names[k], (scalars >> k & 1) != 0});
      const Program program(outputs, inputs);
      for (const std::size_t rows : {0, 1, 2, 3, 5, 8, 13, 257, 600}) {
        std::vector<std::vector<double>> columns(3, std::vector<double>(rows + 1));
        std::vector<const double*> sources;
        sources.reserve(columns.size());
        for (auto& column : columns) {
          for (double& value : column) value = random.uniform(0.2, 3.0);
          sources.push_back(column.data());
        }
        std::vector<std::vector<double>> results(texts.size(), std::vector<double>(rows + 1, -7.0));
        std::vector<double*> targets;
        targets.reserve(results.size());
        for (auto& result : results) targets.push_back(result.data());
        Program::Workspace workspace;
        program.evaluate(sources, rows, targets, workspace);
        for (std::size_t k = 0; k < texts.size(); ++k) {
          CHECK(results[k][rows] == -7.0);  // nothing is written beyond the rows
          for (std::size_t i = 0; i < rows; ++i) {
            std::vector<double> at(3);
            for (int j = 0; j < 3; ++j) at[j] = columns[j][inputs[j].is_scalar ? 0 : i];
            CAPTURE(set, texts[k], scalars, rows, i, at[0], at[1], at[2]);
            // Terms are at most 3^3 in size, and a dozen roundings apart.
            REQUIRE(results[k][i] ==
                    Approx(outputs[k].value(names, at)).epsilon(4e-15).margin(1e-14));
          }
        }
      }
    }
  });
}
