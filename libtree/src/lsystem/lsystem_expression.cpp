// SPDX-License-Identifier: MIT
#include "lsystem/lsystem_expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

namespace silvafit::tree {

using Kind = LsystemExpression::Kind;
using Compute = LsystemExpression::Compute;

namespace {

// Deep nesting ends in an error, not in a stack overflow.
/// A pair of parentheses counts twice: for itself, and for a sign or power before it.
constexpr int kDeepest = 200;
constexpr std::size_t kStack = 256;

double divided(double a, double b) {
  if (b == 0.0) throw ArithmeticProblem{"division by zero"};
  return a / b;
}

double remainder(double a, double b) {
  if (b == 0.0) throw ArithmeticProblem{"remainder (%) of a division by zero"};
  return std::fmod(a, b);
}

double root(double a) {
  if (a < 0.0) throw ArithmeticProblem{fmt::format("square root of {}", a)};
  return std::sqrt(a);
}

double logarithm(double a) {
  if (!(a > 0.0)) throw ArithmeticProblem{fmt::format("logarithm of {}", a)};
  return std::log(a);
}

double power(double a, double b) {
  const double result = std::pow(a, b);
  if (std::isnan(result)) throw ArithmeticProblem{fmt::format("{} to the power of {}", a, b)};
  return result;
}

double normal(double mean, double standard_deviation, Random& random) {
  if (standard_deviation < 0.0) {
    throw ArithmeticProblem{
        fmt::format("negative standard deviation in normal({}, {})", mean, standard_deviation)};
  }
  return random.normal(mean, standard_deviation);
}

double sign_changed(double a, double, Random&) { return -a; }
double is_zero(double a, double, Random&) { return a == 0.0 ? 1.0 : 0.0; }
double is_not_zero(double a, double, Random&) { return a != 0.0 ? 1.0 : 0.0; }
double to_power(double a, double b, Random&) { return power(a, b); }

struct Function {
  std::string_view name;
  int arguments;
  Compute compute;
  Kind kind = Kind::kOperation;
};
constexpr std::array kFunctions{
    Function{"sqrt", 1, [](double a, double, Random&) { return root(a); }},
    Function{"sin", 1, [](double a, double, Random&) { return std::sin(a); }},
    Function{"cos", 1, [](double a, double, Random&) { return std::cos(a); }},
    Function{"tan", 1, [](double a, double, Random&) { return std::tan(a); }},
    Function{"exp", 1, [](double a, double, Random&) { return std::exp(a); }},
    Function{"log", 1, [](double a, double, Random&) { return logarithm(a); }},
    Function{"abs", 1, [](double a, double, Random&) { return std::abs(a); }},
    Function{"floor", 1, [](double a, double, Random&) { return std::floor(a); }},
    Function{"ceil", 1, [](double a, double, Random&) { return std::ceil(a); }},
    Function{"pow", 2, to_power},
    Function{"min", 2, [](double a, double b, Random&) { return std::min(a, b); }},
    Function{"max", 2, [](double a, double b, Random&) { return std::max(a, b); }},
    Function{"rnd", 2, [](double a, double b, Random& r) { return r.uniform(a, b); }, Kind::kDraw},
    Function{"normal", 2, normal, Kind::kDraw},
};

/// Operators between two values, those that bind loosest first.
enum Binding { kComparison, kSum, kProduct, kFactor };
struct Operator {
  std::string_view sign;
  Binding level;
  Compute compute;
};
constexpr std::array kOperators{
    Operator{"==", kComparison, [](double a, double b, Random&) { return a == b ? 1.0 : 0.0; }},
    Operator{"!=", kComparison, [](double a, double b, Random&) { return a != b ? 1.0 : 0.0; }},
    Operator{"<=", kComparison, [](double a, double b, Random&) { return a <= b ? 1.0 : 0.0; }},
    Operator{">=", kComparison, [](double a, double b, Random&) { return a >= b ? 1.0 : 0.0; }},
    Operator{"<", kComparison, [](double a, double b, Random&) { return a < b ? 1.0 : 0.0; }},
    Operator{">", kComparison, [](double a, double b, Random&) { return a > b ? 1.0 : 0.0; }},
    Operator{"+", kSum, [](double a, double b, Random&) { return a + b; }},
    Operator{"-", kSum, [](double a, double b, Random&) { return a - b; }},
    Operator{"*", kProduct, [](double a, double b, Random&) { return a * b; }},
    Operator{"/", kProduct, [](double a, double b, Random&) { return divided(a, b); }},
    Operator{"%", kProduct, [](double a, double b, Random&) { return remainder(a, b); }},
};

}  // namespace

double LsystemExpression::run(const double* parameters, Random& random) const {
  std::array<double, kStack> stack;  // NOLINT: filled as far as it is read
  std::size_t top = 0;               // one past the last value
  for (std::size_t i = 0; i < code_.size(); ++i) {
    const Instruction& instruction = code_[i];
    switch (instruction.kind) {
      case Kind::kNumber:
        stack[top++] = instruction.number;
        break;
      case Kind::kParameter:
        stack[top++] = parameters[instruction.index];
        break;
      case Kind::kSkipIfFalse:
      case Kind::kSkipIfTrue:
        if ((stack[top - 1] != 0.0) == (instruction.kind == Kind::kSkipIfTrue)) {
          i = instruction.index - 1;
        } else {
          --top;
        }
        break;
      case Kind::kOperation:
      case Kind::kDraw:
        // The index is the number of values that it takes. One value stands for both.
        top -= instruction.index - 1;
        stack[top - 1] =
            instruction.compute(stack[top - 1], stack[top + instruction.index - 2], random);
    }
  }
  if (!std::isfinite(stack[0])) throw ArithmeticProblem{"the number is too large"};
  return stack[0];
}

bool LsystemExpression::draws_random_numbers() const {
  return std::any_of(code_.begin(), code_.end(), [](const Instruction& instruction) {
    return instruction.kind == Kind::kDraw;
  });
}

/// Recursive descent, lowest precedence first; code is generated while reading.
class ExpressionParser {
 public:
  ExpressionParser(GrammarCursor& cursor, const ExpressionNames& names)
      : cursor_(cursor), names_(names) {}

  LsystemExpression parse() {
    cursor_.skip_blanks();
    const std::size_t begin = cursor_.position();
    either();
    std::string_view read = cursor_.since(begin);
    while (!read.empty() && is_blank(read.back())) read.remove_suffix(1);
    result_.text_ = std::string(read);
    fold(begin);
    return std::move(result_);
  }

 private:
  using Instruction = LsystemExpression::Instruction;

  [[noreturn]] void fail(std::string message) const {
    refuse_grammar(cursor_.position(), std::move(message));
  }

  void push(const Instruction& value) {
    result_.code_.push_back(value);
    if (++height_ > kStack)
      fail("the expression is nested too deeply; split it into simpler parts");
  }

  void push_number(double value) { push({.kind = Kind::kNumber, .number = value}); }

  void emit(Compute compute, int arguments, Kind kind = Kind::kOperation) {
    result_.code_.push_back(
        {.kind = kind, .index = static_cast<std::uint32_t>(arguments), .compute = compute});
    height_ -= static_cast<std::size_t>(arguments - 1);
  }

  /// A sub-expression without names is evaluated now.
  void fold(std::size_t offset) {
    auto& code = result_.code_;
    const bool varies = std::any_of(code.begin(), code.end(), [](const Instruction& one) {
      return one.kind == Kind::kParameter || one.kind == Kind::kDraw;
    });
    if (varies) return;
    try {
      Random unused(0);
      const double value = result_.run(nullptr, unused);
      code = {{.kind = Kind::kNumber, .number = value}};
    } catch (const ArithmeticProblem& problem) {
      refuse_grammar(offset, problem.message + " has no value");
    }
  }

  void either() {
    if (++depth_ > kDeepest) fail("parentheses are nested too deeply");
    both();
    while (cursor_.accept("||")) skippable(Kind::kSkipIfTrue, [this] { both(); });
    --depth_;
  }

  void both() {
    operation(kComparison);
    while (cursor_.accept("&&")) skippable(Kind::kSkipIfFalse, [this] { operation(kComparison); });
  }

  template <typename Right>
  void skippable(Kind skip, Right right) {
    const std::size_t place = result_.code_.size();
    result_.code_.push_back({.kind = skip});
    --height_;
    right();
    result_.code_[place].index = static_cast<std::uint32_t>(result_.code_.size());
    emit(is_not_zero, 1);
  }

  const Operator* accepted(int level) {
    // The arrow of a production ends a condition.
    if (cursor_.at_arrow()) return nullptr;
    const auto* found = std::ranges::find_if(kOperators, [&](const Operator& one) {
      return one.level == level && cursor_.accept(one.sign);
    });
    return found == kOperators.end() ? nullptr : found;
  }

  void operation(int level) {
    if (level == kFactor) return signed_factor();
    operation(level + 1);
    while (const Operator* found = accepted(level)) {
      operation(level + 1);
      emit(found->compute, 2);
      if (level == kComparison) return;
    }
    if (level == kComparison && cursor_.at("=")) fail("use '==' for comparisons, not '='");
  }

  void signed_factor() {
    if (++depth_ > kDeepest) fail("signs and powers are nested too deeply");
    if (cursor_.accept("-")) {
      signed_factor();
      emit(sign_changed, 1);
    } else if (cursor_.accept("+")) {
      signed_factor();
    } else if (!cursor_.at("!=") && cursor_.accept("!")) {
      signed_factor();
      emit(is_zero, 1);
    } else {
      primary();
      if (cursor_.accept("^")) {
        signed_factor();
        emit(to_power, 2);
      }
    }
    --depth_;
  }

  void primary() {
    const char next = cursor_.peek();
    if (is_digit(next) || next == '.') return number();
    if (is_letter(next) || next == '_') return named();
    const std::size_t open = cursor_.position();
    if (cursor_.accept("(")) {
      either();
      if (!cursor_.accept(")")) refuse_grammar(open, "this '(' is not closed");
      return;
    }
    if (next == '\0') fail("expected a number, a name or '(' at the end");
    fail(fmt::format("expected a number, a name or '(', not '{}'", next));
  }

  void number() {
    double value = 0.0;
    const std::string_view text = cursor_.rest();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::result_out_of_range) fail("this number is too large or too small");
    if (error != std::errc()) fail("not a number");
    cursor_.take(static_cast<std::size_t>(end - text.data()));
    push_number(value);
  }

  void named() {
    const std::size_t begin = cursor_.position();
    const std::string_view name = cursor_.word();
    if (cursor_.accept("(")) return call(name, begin);
    const auto& parameters = names_.parameters;
    const auto parameter = std::find(parameters.begin(), parameters.end(), name);
    if (parameter != parameters.end()) {
      return push({.kind = Kind::kParameter,
                   .index = static_cast<std::uint32_t>(parameter - parameters.begin())});
    }
    const auto constant = names_.constants->find(name);
    if (constant != names_.constants->end()) return push_number(constant->second);
    if (name == "pi") return push_number(std::numbers::pi);
    refuse_grammar(begin, unknown(name));
  }

  std::string unknown(std::string_view name) const {
    std::string known;
    for (const std::string& parameter : names_.parameters) known += " " + parameter;
    for (const auto& [constant, value] : *names_.constants) known += " " + constant;
    return fmt::format(
        "unknown name '{}'; it must be a parameter of the production or #defined above{}{}",
        name.substr(0, 40),
        known.empty() ? "" : "; available:",
        known.substr(0, 200));
  }

  /// After the parenthesis that begins the arguments.
  void call(std::string_view name, std::size_t begin) {
    const auto function = std::find_if(kFunctions.begin(),
                                       kFunctions.end(),
                                       [&](const Function& one) { return one.name == name; });
    if (function == kFunctions.end()) {
      std::string known;
      for (const Function& one : kFunctions) known += fmt::format(" {}", one.name);
      refuse_grammar(begin,
                     fmt::format("unknown function '{}'; available:{}", name.substr(0, 40), known));
    }
    int arguments = 0;
    do {
      either();
      ++arguments;
    } while (cursor_.accept(","));
    if (!cursor_.accept(")")) refuse_grammar(begin, fmt::format("{}( is not closed", name));
    if (arguments != function->arguments) {
      refuse_grammar(begin,
                     fmt::format("{} takes {} argument{}, not {}",
                                 name,
                                 function->arguments,
                                 function->arguments == 1 ? "" : "s",
                                 arguments));
    }
    emit(function->compute, arguments, function->kind);
  }

  GrammarCursor& cursor_;
  const ExpressionNames& names_;
  LsystemExpression result_{};
  std::size_t height_ = 0;
  int depth_ = 0;
};

LsystemExpression LsystemExpression::parse(GrammarCursor& cursor, const ExpressionNames& names) {
  return ExpressionParser(cursor, names).parse();
}

}  // namespace silvafit::tree
