// SPDX-License-Identifier: MIT
#include "silvafit/tree/lsystem.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "reference.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

std::string derived(const std::string& text, int iterations, std::uint64_t seed = 1) {
  Random random(seed);
  return Grammar::parse(text, "test.lsys").derive(random, iterations).text();
}

/// Message of the error that parsing ends with, and its place.
std::string mistake(const std::string& text) {
  try {
    Grammar::parse(text, "g");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string mistake_in_step(const std::string& text, int iterations, LsystemLimits limits = {}) {
  const Grammar grammar = Grammar::parse(text, "g");
  Random random(1);
  try {
    static_cast<void>(grammar.derive(random, iterations, limits));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// The value of an expression in a condition-free production.
double computed(const std::string& expression) {
  const Grammar grammar =
      Grammar::parse("#define k 3\naxiom: A(2, 5)\nA(x, y) -> R(" + expression + ")", "g");
  Random random(1);
  return grammar.derive(random, 1).parameters(0)[0];
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("Lindenmayer's algae have the published strings") {
  // ABOP, section 1.2: the strings of the first five steps.
  const std::string algae = "axiom: B\nA -> AB\nB -> A";
  CHECK(derived(algae, 0) == "B");
  CHECK(derived(algae, 1) == "A");
  CHECK(derived(algae, 2) == "AB");
  CHECK(derived(algae, 3) == "ABA");
  CHECK(derived(algae, 4) == "ABAAB");
  CHECK(derived(algae, 5) == "ABAABABA");
}

TEST_CASE("a parametric L-system with conditions has the published strings") {
  // ABOP, section 1.10.1, the example with its first derivation steps.
  const std::string text =
      "axiom: B(2)A(4, 4)\n"
      "A(x, y) : y <= 3 -> A(x*2, x+y)\n"
      "A(x, y) : y > 3 -> B(x)A(x/y, 0)\n"
      "B(x) : x < 1 -> C\n"
      "B(x) : x >= 1 -> B(x-1)\n";
  CHECK(derived(text, 1) == "B(1)B(4)A(1, 0)");
  CHECK(derived(text, 2) == "B(0)B(3)A(2, 1)");
  CHECK(derived(text, 3) == "CB(2)A(4, 3)");
  CHECK(derived(text, 4) == "CB(1)A(8, 7)");
}

TEST_CASE("published curves and plants have their numbers of segments") {
  const auto segments = [](const std::string& text, int iterations) {
    Random random(1);
    return Grammar::parse(text, "g").derive(random, iterations).count("F");
  };
  // ABOP figure 1.6: each segment of the quadratic Koch island becomes eight.
  CHECK(segments("axiom: F-F-F-F\nF -> F-F+F+FF-F-F+F", 3) == std::size_t{4} * 512);
  // Figure 1.24, a to f, at their numbers of steps. F grows by its own rule to the power, or by
  // F(n+1) = 2 F(n) + k X(n) with X(n) = b^n: F(n) = k (b^n - 2^n) / (b - 2).
  CHECK(segments("axiom: F\nF -> F[+F]F[-F]F", 5) == 3125);
  CHECK(segments("axiom: F\nF -> F[+F]F[-F][F]", 5) == 3125);
  CHECK(segments("axiom: F\nF -> FF-[-F+F+F]+[+F-F-F]", 4) == 4096);
  CHECK(segments("axiom: X\nX -> F[+X]F[-X]+X\nF -> FF", 7) == std::size_t{2} * (2187 - 128));
  CHECK(segments("axiom: X\nX -> F[+X][-X]FX\nF -> FF", 7) == std::size_t{2} * (2187 - 128));
  CHECK(segments("axiom: X\nX -> F-[[X]+X]+F[+FX]-X\nF -> FF", 5) ==
        std::size_t{3} * (1024 - 32) / 2);
}

TEST_CASE("the bush of ABOP figure 1.25 has the numbers of its recurrence") {
  const std::string bush =
      "axiom: A\n"
      "A -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\n"
      "F -> S/////F\n"
      "S -> FL\n"
      "L -> ['''^^{-f+f+f-|-f+f+f}]\n";
  const Grammar grammar = Grammar::parse(bush, "g");
  long apices = 1;
  long segments = 0;
  long stems = 0;
  long leaves = 0;
  long outlines = 0;
  for (int n = 0; n <= 7; ++n) {
    Random random(1);
    const ModuleString string = grammar.derive(random, n);
    CHECK(string.count("A") == static_cast<std::size_t>(apices));
    CHECK(string.count("F") == static_cast<std::size_t>(segments));
    CHECK(string.count("S") == static_cast<std::size_t>(stems));
    CHECK(string.count("L") == static_cast<std::size_t>(leaves));
    CHECK(string.count("{") == static_cast<std::size_t>(outlines));
    outlines += leaves;
    leaves = 3 * apices + stems;
    const long new_segments = segments + stems + 3 * apices;
    stems = segments;
    segments = new_segments;
    apices *= 3;
  }
}

TEST_CASE("the paper's tree has 2^n - 1 segments") {
  // A gives one segment, one B and itself, B one segment and two C, C one segment and two B: after
  // n steps 2^n - 1 of B and C, and as many segments.
  const Grammar grammar = Grammar::load(test::source_file("models/grammars/honda.lsys"));
  for (int n = 0; n <= 9; ++n) {
    Random random(1);
    const ModuleString string = grammar.derive(random, n);
    const std::size_t power = 1U << static_cast<unsigned>(n);
    CHECK(string.count("F") == power - 1);
    CHECK(string.count("B") + string.count("C") == power - 1);
    CHECK(string.count("A") == 1);
    CHECK(string.count("[") == power - 1);
  }
  Random random(1);
  CHECK(grammar.derive(random, 1).text() ==
        "!(0.1)F(1)[&(45)B(0.67, 0.045000000000000005)]/(62)A(0.8, 0.045000000000000005)");
  CHECK(grammar.iterations() == 7);
  CHECK_FALSE(grammar.is_random());
}

TEST_CASE("expressions are computed as in mathematics") {
  CHECK(computed("1 + 2*x - y/4") == 1 + 4 - 1.25);
  CHECK(computed("-x^2") == -4);
  CHECK(computed("2^3^2") == 512);
  CHECK(computed("2^-1") == 0.5);
  CHECK(computed("-7 % 4 + x*0") == std::fmod(-7.0, 4.0));
  CHECK(computed("(x + y) * k") == 21);
  CHECK(computed("x < y && !(x == 2) || y >= 5") == 1);
  CHECK(computed("x != 2 || y <= 4") == 0);
  CHECK(computed("x > 0 && y/x > 2") == 1);
  CHECK(computed("x < 0 && y/0 > 2") == 0);
  CHECK(computed("x > 0 || y/0 > 2") == 1);
  CHECK(computed("sqrt(x*8) + abs(-x) + min(x, y) + max(x, y)") == 4 + 2 + 2 + 5);
  CHECK(computed("floor(y/x) + ceil(y/x) + pow(x, 3)") == 2 + 3 + 8);
  CHECK(computed("exp(log(y))") == Approx(5).epsilon(1e-14));
  CHECK(computed("sin(x)^2 + cos(x)^2 - tan(0*x)") == Approx(1).epsilon(1e-14));
  CHECK(computed("sin(pi/x)") == 1);
  CHECK(computed("1.5e2*x") == 300);
}

TEST_CASE("random numbers have their distributions") {
  const Grammar grammar = Grammar::parse("axiom: A\nA -> R(rnd(2, 4), normal(10, 3)) A", "g");
  CHECK(grammar.is_random());
  constexpr int kNumber = 1000;
  double sum = 0.0;
  double normal_sum = 0.0;
  double squares = 0.0;
  Random random(3);
  const ModuleString string = grammar.derive(random, kNumber);
  for (std::size_t i = 0; i < kNumber; ++i) {
    const auto drawn = string.parameters(i);
    REQUIRE((drawn[0] >= 2.0 && drawn[0] < 4.0));
    sum += drawn[0];
    normal_sum += drawn[1];
    squares += (drawn[1] - 10.0) * (drawn[1] - 10.0);
  }
  // Four standard errors: 4 * (2 / sqrt(12)) / sqrt(1000), 4 * 3 / sqrt(1000), and for the
  // variance 4 * 9 * sqrt(2 / 1000).
  CHECK(sum / kNumber == Approx(3).margin(0.073));
  CHECK(normal_sum / kNumber == Approx(10).margin(0.38));
  CHECK(squares / kNumber == Approx(9).margin(1.61));
}

TEST_CASE("productions are chosen in proportion to their weights") {
  const std::string text =
      "axiom: A\n"
      "A : * : 1 -> X A\n"
      "A : * : 2 -> Y A\n"
      "A : * : 0.5 + 0.5 -> Z A\n";
  constexpr int kNumber = 1000;
  const Grammar grammar = Grammar::parse(text, "g");
  double chi_square = 0.0;
  Random random(5);
  const ModuleString string = grammar.derive(random, kNumber);
  for (const auto& [name, share] : {std::pair{"X", 0.25}, {"Y", 0.5}, {"Z", 0.25}}) {
    const double expected = kNumber * share;
    const double off = static_cast<double>(string.count(name)) - expected;
    chi_square += off * off / expected;
  }
  // The 0.999 quantile of chi-square with two degrees of freedom.
  CHECK(chi_square < 13.82);
  CHECK(derived(text, 30, 1) == derived(text, 30, 1));
  CHECK(derived(text, 30, 1) != derived(text, 30, 2));
}

TEST_CASE("weights may depend on parameters, and conditions restrict the choice") {
  const std::string text =
      "axiom: A(0)\n"
      "A(n) : n < 20 : 20 - n -> X A(n + 1)\n"
      "A(n) : n < 20 : n + 1e-12 -> Y A(n + 1)\n"
      "A(n) : n >= 20 -> E\n";
  const std::string string = derived(text, 40);
  CHECK(string.size() == 21);
  CHECK(string.front() == 'X');
  CHECK(string.back() == 'E');
}

TEST_CASE("a text may have comments, continued lines, long names, settings, symbols") {
  const Grammar grammar = Grammar::parse(
      "\xef\xbb\xbf# a comment\r\n"
      "## another\r\n"
      "modules: Apex, Ape\r\n"
      "#define a 20 # of degrees\r\n"
      "#define b a*2\r\n"
      "angle: b\r\nlength: 2\r\nwidth: 0.5\r\nwidth_ratio: 0.8\r\nelasticity: 0.22\r\n"
      "tropism: 0, 1, -1\r\n"
      "iterations: 3\r\n"
      "axiom: Apex(1)\r\n"
      "  Ape\r\n"
      "\r\n"
      "\t~L(2) ~B # and so on\r\n"
      "Apex (x) --> F(x)\\/|$!'@[+-&^{f}] Apex(x + b)\r\n"
      "Ape ->\r\n",
      "g");
  CHECK(grammar.constants().at("b") == 40);
  CHECK(grammar.turtle().angle_deg == 40);
  CHECK(grammar.turtle().length == 2);
  CHECK(grammar.turtle().width == 0.5);
  CHECK(grammar.turtle().width_ratio == 0.8);
  CHECK(grammar.turtle().elasticity == 0.22);
  CHECK(grammar.turtle().tropism.y == 1);
  CHECK(grammar.iterations() == 3);
  Random random(1);
  CHECK(grammar.derive(random, 0).text() == "Apex(1)Ape~L(2)~B");
  CHECK(grammar.derive(random, 1).text() == "F(1)\\/|$!'@[+-&^{f}]Apex(41)~L(2)~B");
}

TEST_CASE("constants can be replaced, and those computed from them follow") {
  const std::string text = "#define a 2\n#define b a*10\naxiom: F(a, b)";
  Random random(1);
  CHECK(Grammar::parse(text, "g").derive(random).text() == "F(2, 20)");
  CHECK(Grammar::parse(text, "g", {{"a", 3}}).derive(random).text() == "F(3, 30)");
  CHECK_THROWS_AS(Grammar::parse(text, "g", {{"c", 3}}), UsageError);
  CHECK_THROWS_AS(Grammar::parse(text, "g", {{"a", NAN}}), UsageError);
}

TEST_CASE("a cut removes the rest of its branch") {
  // As in ABOP, section 1.10.3: a dying apex removes what follows it.
  const std::string text = "axiom: A[B[C]D]E\nB -> X%";
  CHECK(derived(text, 1) == "A[X]E");
  CHECK(derived("axiom: A%B[C]D", 0) == "A");
  CHECK(derived("axiom: F[+A[B]%[C]F]-F", 0) == "F[+A[B]]-F");
}

TEST_CASE("errors have line and column") {
  CHECK(mistake("axiom: F(x)") ==
        "g:1: column 10: unknown name 'x'; it must be a parameter of the production or #defined "
        "above");
  CHECK(contains(mistake("axiom: F\nF -> F[+F"), "g:2: column 7: this '[' is not closed"));
  CHECK(contains(mistake("axiom: F\nF -> F]+F"), "g:2: column 7: ']' without a matching '['"));
  CHECK(contains(mistake("axiom: F[{F]}"),
                 "g:1: column 12: ']' does not match the '{' at column 10"));
  CHECK(contains(mistake("axiom: {f{f}}"), "column 10: outlines { } must not be nested"));
  CHECK(contains(mistake("F -> FF"), "no axiom; add a line"));
  CHECK(contains(mistake(""), "no axiom; add a line"));
  CHECK(contains(mistake("axiom:"), "the axiom is empty"));
  CHECK(contains(mistake("axiom: F\naxiom: G"), "g:2: column 1: axiom is set twice"));
  CHECK(
      contains(mistake("#define a 1\n#define a 2\naxiom: F"), "g:2: column 9: a is defined twice"));
  CHECK(contains(mistake("#define a 1\naxiom: A(1)\nA(a) -> F"), "column 3: a is #defined"));
  CHECK(contains(mistake("axiom: A(1, 2)\nA(x, x) -> F"), "two parameters have the name x"));
  CHECK(contains(mistake("axiom: A(1)\nA(x, y) -> F"),
                 "g:2: column 1: A has 2 parameters here, but 1 in line 1"));
  CHECK(contains(mistake("axiom: A\nA -> F\nA -> G"),
                 "g:3: column 1: this production never applies: line 2"));
  CHECK(contains(mistake("axiom: A\nA -> F\nA : * : 1 -> G"),
                 "that of line 2, which rewrite A, only one has a weight"));
  CHECK(contains(mistake("axiom: A\nA : * : 0 -> G"), "column 9: a weight must be above 0"));
  CHECK(contains(mistake("axiom: A\nA < B > C -> G"), "contexts ('<' and '>') are not supported"));
  CHECK(contains(mistake("axiom: A B > C"), "contexts"));
  CHECK(contains(mistake("axiom: F;"), "column 9: ';' is not a module"));
  CHECK(contains(mistake("axiom: F\xc3\xa4"), "byte 0xc3 is not a module"));
  CHECK(contains(mistake("axiom: F1"), "put a number in parentheses"));
  CHECK(contains(mistake("axiom: ~K"), "'~' must be followed by a leaf"));
  CHECK(contains(mistake("axiom: F(1"), "this '(' is not closed"));
  CHECK(contains(mistake("axiom: F(1 2)"), "column 12: expected ',' or ')', not '2'"));
  CHECK(contains(mistake("axiom: F(1/0)"), "division by zero has no value"));
  CHECK(contains(mistake("axiom: F(sqrt(-1))"), "square root of -1"));
  CHECK(contains(mistake("axiom: F(1e400)"), "too large"));
  CHECK(contains(mistake("axiom: F(sine(1))"), "unknown function 'sine'; available: sqrt sin"));
  CHECK(contains(mistake("axiom: F(pow(1))"), "pow takes 2 arguments, not 1"));
  CHECK(contains(mistake("axiom: A(1)\nA(x) : x = 1 -> F"), "use '==' for comparisons, not '='"));
  CHECK(contains(mistake("#define a rnd(0, 1)\naxiom: F"), "must be one number"));
  CHECK(contains(mistake("#include \"x\"\naxiom: F"), "use '#define NAME expression'"));
  CHECK(contains(mistake("#defin a 1\naxiom: F"), "use '#define NAME expression'"));
  CHECK(contains(mistake("angel: 1\naxiom: F"), "unknown setting 'angel'; available: modules"));
  CHECK(contains(mistake("iterations: 2000\naxiom: F"), "iterations is 2000, outside [0, 1000]"));
  CHECK(contains(mistake("iterations: 2.5\naxiom: F"), "must be an integer"));
  CHECK(contains(mistake("axiom: F\nnonsense"), "g:2: column 2: expected ':' or '->'"));
  CHECK(contains(mistake("axiom: F\nF"), "not a #define"));
  CHECK(contains(mistake("axiom: F\n  F -> FF"), "g:2: column 5: a second '->'"));
  CHECK(contains(mistake("axiom: F\n[ -> F"), "'[' cannot be rewritten"));
  CHECK(contains(mistake("axiom: F\nF(1) -> F"), "use a condition for a required value"));
}

TEST_CASE("several errors are reported at once, in the order of the text") {
  const std::string text = mistake("axiom: F(x)\nA -> [\n\nB -> ]\n");
  CHECK(contains(text, "g:1: column 10"));
  CHECK(contains(text, "\ng:2: column 6"));
  CHECK(contains(text, "\ng:4: column 6"));
}

TEST_CASE("errors in a derivation name module, line and step") {
  CHECK(mistake_in_step("axiom: A(2)\nA(x) -> A(x - 1) F(1/x)", 9) ==
        "g:2: step 3, A(0): a parameter, 1/x, is not valid: division by zero");
  CHECK(
      contains(mistake_in_step("axiom: A(1)\nA(x) : 1/(x - 1) > 2 -> F", 1),
               "g:2: step 1, A(1): the condition, 1/(x - 1) > 2, is not valid: division by zero"));
  CHECK(contains(mistake_in_step("axiom: A(10)\nA(x) -> A(x^x)", 9), "the number is too large"));
  CHECK(contains(mistake_in_step("axiom: A(1)\nA(x) : * : x - 1 -> F", 1),
                 "the weight x - 1 is 0; it must be above 0"));
  CHECK(contains(mistake_in_step("axiom: A(1)\nA(x) : x > 0 -> F\nA(x) : x < 2 : 1 -> G", 1),
                 "g:2: step 1, A(1): this production and that of line 3 match the same module"));
  CHECK(mistake_in_step("axiom: A(1)\nA(x) : x > 2 -> F\nA(x) : x < 2 : 1 -> G", 1) == "accepted");
}

TEST_CASE("a hostile grammar soon ends with an error") {
  CHECK(contains(mistake_in_step("axiom: F\nF -> FF", 1000), "exceeds 2000000 modules"));
  CHECK(contains(mistake_in_step("axiom: F\nF -> F[F[F[F]]]", 500), "exceeds 2000000 modules"));
  CHECK(contains(mistake_in_step("axiom: F(1,2,3,4,5,6)\nF(a,b,c,d,e,f) -> F(f,e,d,c,b,a)"
                                 "F(a,b,c,d,e,f)",
                                 1000),
                 "8000000 parameters"));
  // The string does not grow, but every step needs time.
  std::string still = "axiom: ";
  for (int i = 0; i < 20000; ++i) still += "A(1)";
  CHECK(contains(mistake_in_step(still + "\nA(x) -> A(sin(x))", 1000, {.operations = 1'000'000}),
                 "takes more than 1000000 operations"));
  CHECK(contains(mistake("axiom: " + std::string(8'000'000, 'F')),
                 "the limit for a grammar is 1048576"));
  CHECK(contains(mistake("axiom: F(" + std::string(500'000, '(') + "1"), "too deeply"));
  CHECK(contains(mistake("axiom: F(" + std::string(500'000, '-') + "1)"), "too deeply"));
  CHECK(contains(mistake("axiom: " + std::string(500'000, '[')), "too deeply"));
  std::string powers = "axiom: F(2";
  for (int i = 0; i < 100'000; ++i) powers += "^2";
  CHECK(contains(mistake(powers + ")"), "too deeply"));
  // A long sum is not deeply nested.
  std::string sum = "axiom: A(1)\nA(x) -> A(x";
  for (int i = 0; i < 100'000; ++i) sum += "+x";
  CHECK(mistake_in_step(sum + ")", 2) == "accepted");
  std::string productions = "axiom: A\n";
  for (int i = 0; i < 100'000; ++i) productions += "A->B\n";
  CHECK(contains(mistake(productions), "There may be more errors."));
  const Grammar grammar = Grammar::parse("axiom: F", "g");
  Random random(1);
  CHECK_THROWS_AS(grammar.derive(random, 1001), UsageError);
  CHECK_THROWS_AS(grammar.derive(random, -1), UsageError);
}
