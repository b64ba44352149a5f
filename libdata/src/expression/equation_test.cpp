// SPDX-License-Identifier: MIT
#include "silvafit/data/equation.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

using silvafit::data::Expression;
using silvafit::data::solve_for;
using silvafit::data::SolvedEquation;

namespace {

/// The part and its value where the equation holds, for a = 0.7, b = 0.4 and d = 12.
struct Sides {
  std::string part{};
  double of_part = 0.0;
  double of_value = 0.0;
};

Sides solved(const std::string& text) {
  const std::vector<std::string> names{"a", "b", "d", "y"};
  const Expression expression = Expression::parse(text);
  std::vector<double> values{0.7, 0.4, 12.0, 0.0};
  values[3] = expression.value(names, values);
  const SolvedEquation result = solve_for(expression, {"a", "b"}, Expression::variable("y"));
  return {.part = result.part.text(),
          .of_part = result.part.value(names, values),
          .of_value = result.value.value(names, values)};
}

}  // namespace

TEST_CASE("an equation is solved for the part with the unknowns") {
  struct Case {
    std::string text{};
    std::string part{};
  };
  const std::vector<Case> cases{
      {"1.3 + d^2/(a + b*d + d^2)", "a + b*d"},
      {"1.3 + d^2/(a + b*d)^2", "a + b*d"},
      {"1.3 + exp(a + b/(d + 1))", "a + b/(d + 1)"},
      {"2 - log(a + b*d)", "a + b*d"},
      {"d^(a + b)", "a + b"},
      {"(a + b*d)^1.7/d", "a + b*d"},
      {"sqrt(log1p(expm1(a*d + b)))", "a*d + b"},
      {"1.3 + a*exp(b*d)", "a*exp(b*d)"},
      {"sin(a + b*d)", "sin(a + b*d)"},
  };
  for (const Case& one : cases) {
    CAPTURE(one.text);
    const Sides sides = solved(one.text);
    CHECK(Expression::parse(sides.part).text() == Expression::parse(one.part).text());
    // Each undone operation rounds a few last digits.
    CHECK(sides.of_value == Approx(sides.of_part).epsilon(1e-12));
  }
}

TEST_CASE("an equation without unknowns is unchanged") {
  const SolvedEquation result =
      solve_for(Expression::parse("1 + d"), {"a"}, Expression::variable("y"));
  CHECK(result.part.text() == Expression::parse("1 + d").text());
  CHECK(result.value.text() == "y");
}
