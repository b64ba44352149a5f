// SPDX-License-Identifier: MIT
#include "silvafit/data/expression_parts.hpp"

#include <catch2/catch.hpp>

using namespace silvafit::data;
using Names = std::vector<std::string>;

namespace {

Names texts_of(const std::vector<Expression>& parts) {
  Names texts;
  for (const Expression& part : parts) texts.push_back(part.text());
  return texts;
}

/// The names of the first finding; empty if there is none.
Names inseparable(const char* formula, const Names& names) {
  const auto found = inseparable_names(Expression::parse(formula), names);
  return found.empty() ? Names{} : found.front().names;
}

}  // namespace

TEST_CASE("summands carry their sign, factors do not") {
  CHECK(texts_of(summands(Expression::parse("a - (b - c*x) + 2"))) == Names{"a", "-b", "c*x", "2"});
  CHECK(texts_of(summands(Expression::parse("exp(a + b)"))) == Names{"exp(a + b)"});
  CHECK(texts_of(factors(Expression::parse("-a*x/(b*z)"))) == Names{"a", "x", "b", "z"});
}

TEST_CASE("self-starting models mention what their formulas mention") {
  const Expression asymptotic = Expression::parse("SSasymp(x, A, R, l)");
  CHECK(use_of(asymptotic, "A").mentions == 2);
  CHECK(use_of(asymptotic, "R").mentions == 1);
  CHECK(inseparable("SSasymp(x, A, R, l)", {"A", "R", "l"}).empty());
  CHECK(inseparable("SSasymp(x, exp(A), R, l)", {"A", "R", "l"}).empty());
}

TEST_CASE("a square mentions its base once") {
  const NameUse use = use_of(Expression::parse("b*d^2*h"), "d");
  CHECK(use.mentions == 1);
  CHECK(use.is_factor_or_base);
  CHECK(use_of(Expression::parse("a + b*d"), "a").is_factor_or_base == false);
  CHECK(use_of(Expression::parse("a*d^c"), "c").is_factor_or_base == false);
  CHECK(use_of(Expression::parse("1.3 + a*d^c"), "d").is_factor_or_base);
  CHECK(use_of(Expression::parse("a + a*x"), "a").mentions == 2);
}

TEST_CASE("names that act together only are found") {
  // Each by pencil: the names are in one part without data, and nowhere else.
  CHECK(inseparable("a + b*dhb", {"a", "b", "dhb"}) == Names{"a", "b", "dhb"});
  CHECK(inseparable("a + b*dhb + c*h", {"a", "b", "dhb", "c"}) == Names{"a", "b", "dhb"});
  CHECK(inseparable("b*d^2*ht", {"b", "ht"}) == Names{"b", "ht"});
  CHECK(inseparable("1.3 + a*(1 - exp(-b*dhb))^c", {"a", "b", "dhb", "c"}).size() == 4);
  CHECK(inseparable("a*d^b*ht^c", {"a", "b", "c", "ht"}) == Names{"a", "ht", "c"});
  CHECK(inseparable("exp(a + b*log(d) + c*log(ht))", {"a", "b", "c", "ht"}) ==
        Names{"a", "c", "ht"});
}

TEST_CASE("names of identifiable models are not inseparable") {
  CHECK(inseparable("A*(1 - exp(-(k*x)^2))", {"A", "k"}).empty());
  CHECK(inseparable("A*(1 - exp(-(b*k*x)^2))", {"A", "b", "k"}) == Names{"b", "k"});
  CHECK(inseparable("1.3 + a*(1 - exp(-b*d))^c", {"a", "b", "c"}).empty());
  CHECK(inseparable("A + (R - A)*exp(-exp(l)*x)", {"A", "R", "l"}).empty());
  CHECK(inseparable("A/(1 + exp((m - x)/s))", {"A", "m", "s"}).empty());
  CHECK(inseparable("A*exp(-b*c^x)", {"A", "b", "c"}).empty());
  CHECK(inseparable("a + b*x + c*x^2", {"a", "b", "c"}).empty());
  CHECK(inseparable("1.3 + d^2/(a + b*d)^2", {"a", "b"}).empty());
}

TEST_CASE("names that a zero removes from a formula are found with their places") {
  const auto vanished = vanished_names("h ~ a + 0*b*dbh + c*(species == \"SM\")*x^0");
  REQUIRE(vanished.size() == 3);
  CHECK(vanished[0].name == "b");
  CHECK(vanished[0].position == 11);
  CHECK(vanished[1].name == "dbh");
  CHECK(vanished[2].name == "x");
  CHECK(vanished_names("h ~ a + b*dbh").empty());
}
