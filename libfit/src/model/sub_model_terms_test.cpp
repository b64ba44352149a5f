// SPDX-License-Identifier: MIT
#include "model/sub_model_terms.hpp"

#include <catch2/catch.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/model_specification.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::FormulaError;

namespace {

/// As R's attr(terms(...), "term.labels"), but variables of a term stay in the order written.
std::string terms_of(const std::string& right_side) {
  const TermFormula formula = parse_terms("b ~ " + right_side);
  std::string result = formula.has_intercept ? "1" : "0";
  for (const Term& term : formula.terms) {
    std::vector<std::string> labels;
    for (const std::size_t variable : term) labels.push_back(formula.variables[variable].label);
    result += " + " + product_label(labels);
  }
  return result;
}

}  // namespace

TEST_CASE("the right side of a sub-model is a model formula of R") {
  struct Expected {
    const char* right_side = nullptr;
    const char* terms = nullptr;
  };
  for (const auto& [right_side, terms] : {
           Expected{"1", "1"},
           Expected{"x", "1 + x"},
           Expected{"0 + x", "0 + x"},
           Expected{"x - 1", "0 + x"},
           Expected{"-1 + x", "0 + x"},
           Expected{"0 + x + 1", "1 + x"},
           Expected{"log(x)*z", "1 + log(x) + z + log(x):z"},
           Expected{"x:z", "1 + x:z"},
           Expected{"x : z + x", "1 + x + x:z"},
           Expected{"x:z + z:x", "1 + x:z"},
           Expected{"x*x", "1 + x"},
           Expected{"a*b:c", "1 + a + b:c + a:b:c"},
           Expected{"(a + b)*c", "1 + a + b + c + a:c + b:c"},
           Expected{"(a + b):c", "1 + a:c + b:c"},
           Expected{"a*b*c", "1 + a + b + c + a:b + a:c + b:c + a:b:c"},
           Expected{"(a + b + c)^2", "1 + a + b + c + a:b + a:c + b:c"},
           Expected{"(a + b)^3", "1 + a + b + a:b"},
           Expected{"(a*b)^2", "1 + a + b + a:b"},
           Expected{"a*b*c - a:b:c", "1 + a + b + c + a:b + a:c + b:c"},
           Expected{"a*b - a", "1 + b + a:b"},
           Expected{"I(x^2) + x", "1 + I(x^2) + x"},
           Expected{"I(x/10 - 1):z", "1 + I(x/10 - 1):z"},
           Expected{"log(x + 1) + log(x+1)", "1 + log(x + 1)"},
           Expected{"pow(x, 2):min(x, z, 3)", "1 + pow(x, 2):min(x, z, 3)"},
           Expected{"`d (cm)`*z", "1 + `d (cm)` + z + `d (cm)`:z"},
           Expected{"factor(plot):x", "1 + factor(plot):x"},
           Expected{"(Year == 1989)*x", "1 + (Year == 1989) + x + (Year == 1989):x"},
           Expected{"x > -3 + z", "1 + x > -3 + z"},
           Expected{"x > 1e-3", "1 + x > 1e-3"},
           Expected{"species == \"A + B:C\" + (zone == '2*')",
                    "1 + species == \"A + B:C\" + (zone == '2*')"},
       }) {
    INFO(right_side);
    CHECK(terms_of(right_side) == terms);
  }
}

TEST_CASE("texts that R does not read as arithmetic are refused, with the remedy") {
  struct Refused {
    const char* right_side = nullptr;
    const char* message = nullptr;
  };
  for (const auto& [right_side, message] : {
           Refused{"x^2", "write I(x^2)"},
           Refused{"x + log(x)^2", "column 9: in R's formulas x^2 is x itself"},
           Refused{"x**2", "on both sides"},
           Refused{"dbh/10", "write I(dbh/10)"},
           Refused{"1 + (x - 5)/10", "write I((x - 5)/10)"},
           Refused{"2*x", "the number 2 is not a term; write I(2*x)"},
           Refused{"x:2", "write I(x:2)"},
           Refused{"(x - 5)", "write I(x - 5)"},
           Refused{"(1 + x)*z", "write I(1 + x)"},
           Refused{"x - 5", "such as I(x - 5)"},
           Refused{"1 + x - z", "there is no term 'z'"},
           Refused{"-x", "there is no term 'x'"},
           Refused{"x - 0", "- 1"},
           Refused{"a %in% b", "a:b"},
           Refused{"poly(x, 2)", "x + I(x^2)"},
           Refused{"offset(x)", "`formula`"},
           Refused{"factor(x + 1)", "one column"},
           Refused{"factor(x == \"a\")", "one column"},
           Refused{"x > 3 - 1", "parentheses"},
           Refused{"x > 3:z", "parentheses"},
           Refused{"x:", "on both sides"},
           Refused{"*x", "on both sides"},
           Refused{"x +", "expected a covariate"},
           Refused{".", "write their names"},
           Refused{"-x", "I(-x)"},
           Refused{"", "expected a covariate"},
           Refused{"(x", "')'"},
           Refused{"x)", "unexpected"},
           Refused{"(a + b)^x", "a number from 1 to 9"},
           Refused{"0", "needs an intercept or a covariate"},
           Refused{"what(x)", "unknown function 'what'"},
       }) {
    INFO(right_side);
    CHECK_THROWS_AS(parse_terms(std::string("b ~ ") + right_side), FormulaError);
    CHECK_THROWS_WITH(parse_terms(std::string("b ~ ") + right_side), Contains(message));
  }
}

TEST_CASE("very long sub-models are refused") {
  CHECK_THROWS_WITH(parse_terms("b ~ " + std::string(5000, '(') + "x" + std::string(5000, ')')),
                    Contains("nested too deeply"));
  CHECK_THROWS_WITH(parse_terms("b ~ (a + b + c + d + e + f + g + h + i + j + k + l)^9"),
                    Contains("too many terms"));
}

TEST_CASE("the columns that a sub-model reads as numbers and as names") {
  const SubModelColumns columns =
      sub_model_columns("b ~ species*log(dbh) + factor(year) + (zone == \"2\") + (age > 3)");
  using Columns = std::vector<std::string>;
  CHECK(columns.as_numbers == Columns{"species", "dbh", "age"});
  CHECK(columns.as_names == Columns{"year", "zone"});
}
