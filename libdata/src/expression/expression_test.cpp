// SPDX-License-Identifier: MIT
#include "silvafit/data/expression.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"

using silvafit::FormulaError;
using silvafit::data::Expression;
using silvafit::data::parse_formula;

namespace {

double value_of(const std::string& text) { return Expression::parse(text).value({}, {}); }

std::size_t position_of_error(const std::string& text) {
  try {
    parse_formula(text);
  } catch (const FormulaError& error) {
    return error.position();
  }
  return 0;
}

}  // namespace

TEST_CASE("operators bind as in mathematics and in R") {
  CHECK(value_of("2+3*4^2") == 50.0);
  CHECK(value_of("-2^2") == -4.0);
  CHECK(value_of("2^-1") == 0.5);
  CHECK(value_of("2^3^2") == 512.0);
  CHECK(value_of("8/4/2") == 1.0);
  CHECK(value_of("8-4-2") == 2.0);
  CHECK(value_of("1.5e2 + .5") == 150.5);
  CHECK(value_of("1 < 2 && !(3 <= 2)") == 1.0);
  CHECK(value_of("1 == 2 || 3 != 3") == 0.0);
  CHECK(value_of("min(3, 1, 2) + max(3, 1, 2)") == 4.0);
  CHECK(value_of("ifelse(2 > 1, 10, 20)") == 10.0);
  CHECK(value_of("pow(2, 10)") == 1024.0);
  CHECK(value_of("sin(pi/2)") == 1.0);
}

TEST_CASE("names may be Chinese, dotted, or in backquotes") {
  const auto names = Expression::parse("胸径 + d.b_h2 * `crown width [m]`").variables();
  CHECK(names == std::vector<std::string>{"胸径", "d.b_h2", "crown width [m]"});
}

TEST_CASE("signs of printed formulas are no letters of names") {
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(parse_formula("h ~ a·dbh"), Contains("write *, or"));
  CHECK_THROWS_WITH(parse_formula("h ~ a × dbh"), Contains("'×' is not a letter of a name"));
  CHECK_THROWS_WITH(parse_formula("h ~ a + b*dbh²"), Contains("write ^2, or"));
  CHECK_THROWS_WITH(parse_formula("h ~ a − b"), Contains("write -, or"));
  CHECK_THROWS_WITH(parse_formula("h ~ a\u00a0+ b"), Contains("write a plain blank"));
  CHECK_THROWS_WITH(Expression::parse("species == “SM”"), Contains("write \", or"));
  CHECK(position_of_error("h ~ a·dbh") == 6);
  CHECK(position_of_error("h ~ a + dbh−b") == 12);
  const Expression quoted = Expression::parse("a*`G m²` + `A_m²`");
  CHECK(quoted.variables() == std::vector<std::string>{"a", "G m²", "A_m²"});
  CHECK(Expression::parse(quoted.text()).variables() == quoted.variables());
}

TEST_CASE("a comparison with text is a separate variable") {
  const Expression expression = Expression::parse("species == \"SM\" && 'MH' != species");
  const auto names = expression.variables();
  REQUIRE(names.size() == 2);
  silvafit::data::TextMatch match;
  REQUIRE(silvafit::data::is_text_match(names[0], match));
  CHECK(match.column == "species");
  CHECK(match.value == "SM");
  CHECK(expression.value(names, {1.0, 0.0}) == 1.0);
  CHECK_FALSE(silvafit::data::is_text_match("dbh", match));
}

TEST_CASE("an error points at its column") {
  CHECK(position_of_error("h ~ 1.3 + a*(1 - exp(-b*dbh)") == 29);
  CHECK(position_of_error("h ~ a * foo(dbh)") == 9);
  CHECK(position_of_error("h ~ a + * b") == 9);
  CHECK(position_of_error("h ~ a b") == 7);
  CHECK(position_of_error("h ~ 2dbh") == 6);
  CHECK(position_of_error("h = a") == 6);
  CHECK(position_of_error("2 ~ a") == 1);
  CHECK(position_of_error("h ~ a + SSlogis(x, b)") == 9);
  CHECK(position_of_error("h ~ exp(a, b)") == 5);
  CHECK(position_of_error("h ~ `a") == 5);
  CHECK(position_of_error("h ~ a + \"SM\"") == 9);
  CHECK(position_of_error("h ~ ") == 5);
  CHECK_THROWS_WITH(parse_formula("h ~ a * foo(dbh)"), Catch::Matchers::Contains("'foo'"));
}

TEST_CASE("hostile formulas end in an error") {
  CHECK_THROWS_AS(Expression::parse(std::string(5000, '(')), FormulaError);
  CHECK_THROWS_AS(Expression::parse(std::string(5000, '-') + "a"), FormulaError);
  CHECK_THROWS_AS(Expression::parse(std::string(100000, '1')), FormulaError);
}

TEST_CASE("text parses back to the same values") {
  const std::vector<std::string> names{"a", "b", "x"};
  const std::vector<double> values{1.7, 0.4, 2.3};
  for (const char* text : {"a - (b - x)",
                           "a/(b*x)",
                           "-(a + b)^2",
                           "(a^b)^x",
                           "a^b^x",
                           "(-a)^2 - -b",
                           "ifelse(a > b && !(x == 2), max(a, b), -x)",
                           "(a < b) < x",
                           "1.3 + a*(1 - exp(-b*x))^3",
                           "x^(-b*a) - (-a*b)/x",
                           "a - 2e-300"}) {
    const Expression expression = Expression::parse(text);
    CAPTURE(text, expression.text());
    CHECK(Expression::parse(expression.text()).value(names, values) ==
          expression.value(names, values));
  }
}

TEST_CASE("derivatives simplify to what one would write") {
  const auto derivative = [](const char* text, const char* name) {
    return Expression::parse(text).derivative(name).text();
  };
  CHECK(derivative("1.3 + a*x^b", "a") == "x^b");
  CHECK(derivative("a + b*x + c*x^2", "c") == "x*x");
  CHECK(derivative("a*x", "b") == "0");
  CHECK(derivative("exp(a + b*x)", "b") == "exp(a + b*x)*x");
  CHECK(Expression::parse("a*x^b").derivative("a").derivative("a").is_zero());
  CHECK(derivative("a*(x > 2)", "x") == "0");
}

namespace {

using Complex = std::complex<double>;

struct AnalyticCase {
  const char* text;
  Complex (*function)(Complex a, Complex b, Complex x);
};

// The same functions written with complex arguments: the imaginary step gives first derivatives to
// rounding.
const std::vector<AnalyticCase> kAnalytic = {
    {"1.3 + a*(1 - exp(-b*x))^3.2",
     [](Complex a, Complex b, Complex x) {
       return 1.3 + a * std::pow(1.0 - std::exp(-b * x), 3.2);
     }},
    {"x^2/(a*x + b)^2",
     [](Complex a, Complex b, Complex x) { return x * x / ((a * x + b) * (a * x + b)); }},
    {"a*x^(b*x^(-a))",
     [](Complex a, Complex b, Complex x) { return a * std::pow(x, b * std::pow(x, -a)); }},
    {"a/(1 + 1/(b*x^a))",
     [](Complex a, Complex b, Complex x) { return a / (1.0 + 1.0 / (b * std::pow(x, a))); }},
    {"log(a + x) * sqrt(b*x) - log10(x)/log2(a)",
     [](Complex a, Complex b, Complex x) {
       return std::log(a + x) * std::sqrt(b * x) - std::log10(x) / (std::log(a) / std::log(2.0));
     }},
    {"sin(a*x)*cos(b) + tan(x*b/4)",
     [](Complex a, Complex b, Complex x) {
       return std::sin(a * x) * std::cos(b) + std::tan(x * b / 4.0);
     }},
    {"asin(b/5)*acos(x/9) + atan(a*x)",
     [](Complex a, Complex b, Complex x) {
       return std::asin(b / 5.0) * std::acos(x / 9.0) + std::atan(a * x);
     }},
    {"sinh(b)*cosh(a/x) + tanh(a*b)",
     [](Complex a, Complex b, Complex x) {
       return std::sinh(b) * std::cosh(a / x) + std::tanh(a * b);
     }},
    {"expm1(b)*log1p(x*a) - -a^b",
     [](Complex a, Complex b, Complex x) {
       return (std::exp(b) - 1.0) * std::log(1.0 + x * a) + std::pow(a, b);
     }},
};

double complex_step(const AnalyticCase& example, int which, double a, double b, double x) {
  constexpr double kStep = 1e-100;
  std::array<Complex, 3> arguments{a, b, x};
  arguments[which] += Complex(0.0, kStep);
  return example.function(arguments[0], arguments[1], arguments[2]).imag() / kStep;
}

}  // namespace

TEST_CASE("first derivatives equal complex steps") {
  const std::vector<std::string> names{"a", "b", "x"};
  for (const auto& example : kAnalytic) {
    const Expression expression = Expression::parse(example.text);
    for (int which = 0; which < 3; ++which) {
      const Expression derivative = expression.derivative(names[which]);
      for (const double a : {0.6, 1.9}) {
        for (const double b : {0.3, 1.2}) {
          for (const double x : {0.8, 7.5}) {
            CAPTURE(example.text, names[which], a, b, x);
            // A few rounding errors on each side; 1e-12 is the requirement of the project.
            CHECK(derivative.value(names, {a, b, x}) ==
                  Approx(complex_step(example, which, a, b, x)).epsilon(1e-12).margin(1e-14));
          }
        }
      }
    }
  }
}

TEST_CASE("piecewise functions differentiate on their branch") {
  const std::vector<std::string> names{"a", "x"};
  const auto derivative = [&names](const char* text, double a, double x) {
    return Expression::parse(text).derivative("a").value(names, {a, x});
  };
  CHECK(derivative("abs(a*x)", -2.0, 3.0) == -3.0);
  CHECK(derivative("min(a*x, 2*a)", 1.0, 3.0) == 2.0);
  CHECK(derivative("max(a*x, 2*a)", 1.0, 3.0) == 3.0);
  CHECK(derivative("ifelse(x > 2, a^3, a)", 2.0, 3.0) == 12.0);
}

TEST_CASE("powers differentiate at a base of zero") {
  // Chapman-Richards at x = 0: the curve and its derivative in c are 0, not NaN.
  const Expression expression = Expression::parse("a*(1 - exp(-b*x))^c");
  const std::vector<std::string> names{"a", "b", "c", "x"};
  const std::vector<double> values{20.0, 0.1, 1.4, 0.0};
  CHECK(expression.value(names, values) == 0.0);
  CHECK(expression.derivative("c").value(names, values) == 0.0);
  CHECK(expression.derivative("b").value(names, values) == 0.0);
}

TEST_CASE("substitution rebuilds and simplifies") {
  const Expression richards = Expression::parse("a*(1 - exp(-b*x))^c");
  CHECK(richards.substitute("c", Expression::constant(1.0)).text() == "a*(1 - exp(-b*x))");
}

TEST_CASE("I() encloses arithmetic, as in R's formulas") {
  CHECK(value_of("2*I(1 + 2)^2") == 18.0);
  CHECK(Expression::parse("I(x^2)").text() == Expression::parse("x^2").text());
  CHECK_THROWS_AS(Expression::parse("I(x, 2)"), FormulaError);
  CHECK(Expression::parse("I*x").variables() == std::vector<std::string>{"I", "x"});
}

TEST_CASE("self-starting models of R have R's values") {
  // R 4.2.2, by bench/r/reference_formulas.R, at 3.
  const std::vector<std::pair<const char*, double>> models{
      {"SSasymp(x, 20, 2, -1.5)", 10.7836297536115},
      {"SSasympOff(x, 20, -1.5, 0.5)", 8.55094867125597},
      {"SSasympOrig(x, 20, -1.5)", 9.75958861512391},
      {"SSbiexp(x, 5, 0.2, 2, -1.1)", 0.86490215688568},
      {"SSfol(4, x, -2.5, 0.5, -3)", 5.37614093003297},
      {"SSfpl(x, 1, 20, 4, 1.5)", 7.44562899344947},
      {"SSgompertz(x, 20, 2, 0.7)", 10.0717278261274},
      {"SSlogis(x, 20, 4, 1.5)", 6.78487262468366},
      {"SSmicmen(x, 200, 0.5)", 171.428571428571},
      {"SSweibull(x, 20, 18, -3, 2)", 8.5006772470712},
  };
  for (const auto& [text, value] : models) {
    INFO(text);
    CHECK(Expression::parse(text).value({"x"}, {3.0}) == Approx(value).epsilon(1e-13));
  }
}

TEST_CASE("arguments of self-starting models are matched as in R") {
  const auto is_same = [](const std::string& text, const std::string& other) {
    return Expression::parse(text).text() == Expression::parse(other).text();
  };
  CHECK(is_same("SSlogis(xmid = m, x/10, scal = s, Asym)", "Asym/(1 + exp((m - x/10)/s))"));
  // Names of the model's own arguments are names like any other.
  CHECK(is_same("SSlogis(xmid, scal, input, Asym)", "scal/(1 + exp((input - xmid)/Asym))"));
  CHECK(is_same("2*SSmicmen(SSmicmen(x, a, b), c, d)", "2*(c*(a*x/(b + x))/(d + a*x/(b + x)))"));
  CHECK(Expression::parse("SSlogis + x").variables() == std::vector<std::string>{"SSlogis", "x"});
  for (const char* const text : {"SSlogis(x, a, b)",
                                 "SSlogis(x, a, b, c, d)",
                                 "SSlogis(x, Asym = a, Asym = b, c)",
                                 "SSlogis(x, asym = a, b, c)"}) {
    CHECK_THROWS_WITH(Expression::parse(text),
                      Catch::Matchers::Contains("SSlogis(input, Asym, xmid, scal)"));
  }
  CHECK_THROWS_AS(Expression::parse("%1 + x"), FormulaError);
}

TEST_CASE("the left side of a formula is a column or an expression of columns") {
  CHECK(parse_formula(" h ~ a").left == "h");
  CHECK(parse_formula("`crown width [m]` ~ a").left == "crown width [m]");
  CHECK(parse_formula("log(h - 1.3) ~ a").left == "log(h - 1.3)");
  CHECK(parse_formula("`log(h)` ~ a").left == parse_formula("log(h) ~ a").left);
  for (const char* const text : {"1.3 ~ a", "~ a", "cbind(h, d) ~ a", "h d ~ a"}) {
    CHECK_THROWS_AS(parse_formula(text), FormulaError);
  }
}

TEST_CASE("an expression has the discontinuities of its derivative") {
  const auto has_kink = [](const char* text) { return Expression::parse(text).has_kink_in("a"); };
  for (const char* text : {"max(a*x, 3)",
                           "x + min(x, exp(-a))",
                           "abs(1 - a)",
                           "sign(a)",
                           "ifelse(a > 2, 1, x)",
                           "(a <= x)*b",
                           "x && a",
                           "!a",
                           "x*(a == 1)"}) {
    INFO(text);
    CHECK(has_kink(text));
  }
  for (const char* text : {"a*max(x, 3)", "ifelse(x > 2, a, b)", "a^2 + abs(x)", "max(b, x)"}) {
    INFO(text);
    CHECK_FALSE(has_kink(text));
  }
}

TEST_CASE("slopes at the edge of a domain are the limits of those inside") {
  // As x falls to 0 the logistic curve of log x reaches its asymptote faster than any power of log
  // x grows, and so does exp(-b/x): the slopes by what shapes the approach have the limit 0.
  const std::vector<std::string> names{"x", "A", "B", "m", "s"};
  const std::vector<double> at{0.0, 5.0, 2.0, -1.0, 0.5};
  const Expression logistic = Expression::parse("A + (B - A)/(1 + exp((m - log(x))/s))");
  CHECK(std::isnan(logistic.derivative("m").value(names, at)));
  const Expression limits = logistic.with_limits();
  CHECK(limits.value(names, at) == 5.0);
  CHECK(limits.derivative("A").value(names, at) == 1.0);
  for (const char* const first : {"B", "m", "s"}) {
    CHECK(limits.derivative(first).value(names, at) == 0.0);
    for (const char* const second : {"A", "B", "m", "s"}) {
      CHECK(limits.derivative(first).derivative(second).value(names, at) == 0.0);
      CHECK(limits.derivative(first).derivative(second).derivative("s").value(names, at) == 0.0);
    }
  }
  const Expression korf = Expression::parse("A*exp(-m*m/x)").with_limits();
  CHECK(korf.text() == Expression::parse("A*exp(-m*m/x)").text());
  CHECK(korf.derivative("m").value(names, at) == 0.0);
  // Inside they are unchanged.
  const std::vector<double> inside{3.0, 5.0, 2.0, -1.0, 0.5};
  for (const char* const name : {"A", "B", "m", "s"}) {
    CHECK(limits.derivative(name).value(names, inside) ==
          Approx(logistic.derivative(name).value(names, inside)).epsilon(1e-14));
  }
}

TEST_CASE(
    "where a zero of the data makes the mean constant, its derivatives are those of a constant") {
  // The mean at x = 0 as a function of the parameters, by hand. All exponents are positive there.
  struct AtZero {
    const char* formula;
    const char* value;
  };
  const AtZero cases[] = {
      {"c + (d - c)/(1 + (x/e)^b)", "d"},
      {"c + (d - c)/(1 + (x/e)^(-b))", "c"},
      {"c + (d - c)/(1 + (e/x)^b)", "c"},
      {"c + d*(1 - exp(-e*x))^b", "c"},
      {"c + d*(x/e)^1.5", "c"},
      {"c + d*(x/e)^2.5", "c"},
      {"c + d*sqrt(x/e)", "c"},
      {"c + d*x^b/(e^b + x^b)", "c"},
      {"c + d*(x/(x + e))^b", "c"},
      {"c + d*exp(-(e/x)^b)", "c"},
      {"c + d*exp(b*log(x/e))", "c"},
      {"d/(c + (e*x)^b)", "d/c"},
      {"exp(c + (e*x)^b)", "exp(c)"},
      {"log(c + (e*x)^b) + tanh((x/d)^b)", "log(c)"},
      {"c*(d + (x/e)^b)^b", "c*d^b"},
  };
  const std::vector<std::string> parameters{"b", "c", "d", "e"};
  std::vector<std::string> names = parameters;
  names.emplace_back("x");
  for (const AtZero& of : cases) {
    const Expression mean = Expression::parse(of.formula).with_limits();
    const Expression exact = Expression::parse(of.value);
    for (const double b : {0.3, 0.5, 1.0, 1.3, 2.0, 2.5, 3.0}) {
      INFO(of.formula << ", b = " << b);
      const std::vector<double> at{b, 0.7, 3.0, 1.7, 0.0};
      const auto check = [&](const Expression& derivative, const Expression& expected) {
        // Sums and products of a few terms.
        const double value = expected.value(names, at);
        CHECK(derivative.value(names, at) == Approx(value).epsilon(1e-13).margin(1e-300));
      };
      check(mean, exact);
      for (const std::string& i : parameters) {
        const Expression by_i = mean.derivative(i);
        const Expression exact_i = exact.derivative(i);
        check(by_i, exact_i);
        for (const std::string& j : parameters) {
          const Expression by_j = by_i.derivative(j);
          const Expression exact_j = exact_i.derivative(j);
          check(by_j, exact_j);
          for (const std::string& k : parameters) check(by_j.derivative(k), exact_j.derivative(k));
        }
      }
    }
  }
}
