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

using Operation = LsystemExpression::Operation;

namespace {

// Deep nesting ends in an error, not in a stack overflow.
/// A pair of parentheses counts twice: for itself, and for a sign or power before it.
constexpr int kDeepest = 200;
constexpr std::size_t kStack = 256;

struct Function {
  std::string_view name;
  Operation operation;
  int arguments;
};
constexpr std::array kFunctions{
    Function{"sqrt", Operation::kSqrt, 1},
    Function{"sin", Operation::kSin, 1},
    Function{"cos", Operation::kCos, 1},
    Function{"tan", Operation::kTan, 1},
    Function{"exp", Operation::kExp, 1},
    Function{"log", Operation::kLog, 1},
    Function{"abs", Operation::kAbs, 1},
    Function{"floor", Operation::kFloor, 1},
    Function{"ceil", Operation::kCeil, 1},
    Function{"pow", Operation::kPower, 2},
    Function{"min", Operation::kMin, 2},
    Function{"max", Operation::kMax, 2},
    Function{"rnd", Operation::kUniform, 2},
    Function{"normal", Operation::kNormal, 2},
};

bool draws(Operation operation) {
  return operation == Operation::kUniform || operation == Operation::kNormal;
}

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

double of_one(Operation operation, double a) {
  switch (operation) {
    case Operation::kNegate:
      return -a;
    case Operation::kNot:
      return a == 0.0 ? 1.0 : 0.0;
    case Operation::kTruth:
      return a != 0.0 ? 1.0 : 0.0;
    case Operation::kSqrt:
      return root(a);
    case Operation::kSin:
      return std::sin(a);
    case Operation::kCos:
      return std::cos(a);
    case Operation::kTan:
      return std::tan(a);
    case Operation::kExp:
      return std::exp(a);
    case Operation::kLog:
      return logarithm(a);
    case Operation::kAbs:
      return std::abs(a);
    case Operation::kFloor:
      return std::floor(a);
    default:
      return std::ceil(a);
  }
}

double of_two(Operation operation, double a, double b, Random& random) {
  switch (operation) {
    case Operation::kAdd:
      return a + b;
    case Operation::kSubtract:
      return a - b;
    case Operation::kMultiply:
      return a * b;
    case Operation::kDivide:
      return divided(a, b);
    case Operation::kRemainder:
      return remainder(a, b);
    case Operation::kPower:
      return power(a, b);
    case Operation::kLess:
      return a < b ? 1.0 : 0.0;
    case Operation::kLessEqual:
      return a <= b ? 1.0 : 0.0;
    case Operation::kGreater:
      return a > b ? 1.0 : 0.0;
    case Operation::kGreaterEqual:
      return a >= b ? 1.0 : 0.0;
    case Operation::kEqual:
      return a == b ? 1.0 : 0.0;
    case Operation::kNotEqual:
      return a != b ? 1.0 : 0.0;
    case Operation::kMin:
      return std::min(a, b);
    case Operation::kMax:
      return std::max(a, b);
    case Operation::kUniform:
      return random.uniform(a, b);
    default:
      return normal(a, b, random);
  }
}

}  // namespace

double LsystemExpression::run(const double* parameters, Random& random) const {
  std::array<double, kStack> stack;  // NOLINT: filled as far as it is read
  std::size_t top = 0;               // one past the last value
  for (std::size_t i = 0; i < code_.size(); ++i) {
    const Instruction& instruction = code_[i];
    switch (instruction.operation) {
      case Operation::kNumber:
        stack[top++] = instruction.number;
        break;
      case Operation::kParameter:
        stack[top++] = parameters[instruction.index];
        break;
      case Operation::kMultiply:
        --top;
        stack[top - 1] *= stack[top];
        break;
      case Operation::kSkipIfFalse:
      case Operation::kSkipIfTrue:
        if ((stack[top - 1] != 0.0) == (instruction.operation == Operation::kSkipIfTrue)) {
          i = instruction.index - 1;
        } else {
          --top;
        }
        break;
      case Operation::kNegate:
      case Operation::kNot:
      case Operation::kTruth:
      case Operation::kSqrt:
      case Operation::kSin:
      case Operation::kCos:
      case Operation::kTan:
      case Operation::kExp:
      case Operation::kLog:
      case Operation::kAbs:
      case Operation::kFloor:
      case Operation::kCeil:
        stack[top - 1] = of_one(instruction.operation, stack[top - 1]);
        break;
      default:
        --top;
        stack[top - 1] = of_two(instruction.operation, stack[top - 1], stack[top], random);
    }
  }
  if (!std::isfinite(stack[0])) throw ArithmeticProblem{"the number is too large"};
  return stack[0];
}

bool LsystemExpression::draws_random_numbers() const {
  return std::any_of(code_.begin(), code_.end(), [](const Instruction& instruction) {
    return draws(instruction.operation);
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

  void emit(Operation operation, std::uint32_t index = 0, double number = 0.0) {
    result_.code_.push_back({operation, index, number});
  }

  void push(Operation operation, std::uint32_t index, double number) {
    emit(operation, index, number);
    if (++height_ > kStack)
      fail("the expression is nested too deeply; split it into simpler parts");
  }

  void binary(Operation operation) {
    emit(operation);
    --height_;
  }

  /// A sub-expression without names is evaluated now.
  void fold(std::size_t offset) {
    auto& code = result_.code_;
    const bool varies = std::any_of(code.begin(), code.end(), [](const Instruction& one) {
      return one.operation == Operation::kParameter || draws(one.operation);
    });
    if (varies) return;
    try {
      Random unused(0);
      const double value = result_.run(nullptr, unused);
      code = {{Operation::kNumber, 0, value}};
    } catch (const ArithmeticProblem& problem) {
      refuse_grammar(offset, problem.message + " has no value");
    }
  }

  void either() {
    if (++depth_ > kDeepest) fail("parentheses are nested too deeply");
    both();
    while (cursor_.accept("||")) skippable(Operation::kSkipIfTrue, [this] { both(); });
    --depth_;
  }

  void both() {
    comparison();
    while (cursor_.accept("&&")) skippable(Operation::kSkipIfFalse, [this] { comparison(); });
  }

  template <typename Right>
  void skippable(Operation skip, Right right) {
    const std::size_t place = result_.code_.size();
    emit(skip);
    --height_;
    right();
    result_.code_[place].index = static_cast<std::uint32_t>(result_.code_.size());
    emit(Operation::kTruth);
  }

  void comparison() {
    sum();
    // The arrow of a production ends a condition.
    if (cursor_.at_arrow()) return;
    const auto compare = [this](Operation operation) {
      sum();
      binary(operation);
    };
    if (cursor_.accept("==")) return compare(Operation::kEqual);
    if (cursor_.accept("!=")) return compare(Operation::kNotEqual);
    if (cursor_.accept("<=")) return compare(Operation::kLessEqual);
    if (cursor_.accept(">=")) return compare(Operation::kGreaterEqual);
    if (cursor_.accept("<")) return compare(Operation::kLess);
    if (cursor_.accept(">")) return compare(Operation::kGreater);
    if (cursor_.at("=")) fail("use '==' for comparisons, not '='");
  }

  void sum() {
    product();
    for (;;) {
      if (cursor_.at_arrow()) return;
      if (cursor_.accept("+")) {
        product();
        binary(Operation::kAdd);
      } else if (cursor_.accept("-")) {
        product();
        binary(Operation::kSubtract);
      } else {
        return;
      }
    }
  }

  void product() {
    signed_factor();
    for (;;) {
      if (cursor_.accept("*")) {
        signed_factor();
        binary(Operation::kMultiply);
      } else if (cursor_.accept("/")) {
        signed_factor();
        binary(Operation::kDivide);
      } else if (cursor_.accept("%")) {
        signed_factor();
        binary(Operation::kRemainder);
      } else {
        return;
      }
    }
  }

  void signed_factor() {
    if (++depth_ > kDeepest) fail("signs and powers are nested too deeply");
    if (cursor_.accept("-")) {
      signed_factor();
      emit(Operation::kNegate);
    } else if (cursor_.accept("+")) {
      signed_factor();
    } else if (!cursor_.at("!=") && cursor_.accept("!")) {
      signed_factor();
      emit(Operation::kNot);
    } else {
      primary();
      if (cursor_.accept("^")) {
        signed_factor();
        binary(Operation::kPower);
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
    push(Operation::kNumber, 0, value);
  }

  void named() {
    const std::size_t begin = cursor_.position();
    const std::string_view name = cursor_.word();
    if (cursor_.accept("(")) return call(name, begin);
    const auto& parameters = names_.parameters;
    const auto parameter = std::find(parameters.begin(), parameters.end(), name);
    if (parameter != parameters.end()) {
      return push(
          Operation::kParameter, static_cast<std::uint32_t>(parameter - parameters.begin()), 0.0);
    }
    const auto constant = names_.constants->find(name);
    if (constant != names_.constants->end()) return push(Operation::kNumber, 0, constant->second);
    if (name == "pi") return push(Operation::kNumber, 0, std::numbers::pi);
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
    emit(function->operation);
    height_ -= static_cast<std::size_t>(arguments - 1);
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
