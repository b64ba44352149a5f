// SPDX-License-Identifier: MIT
#include "silvafit/data/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "expression/expression_derivative.hpp"
#include "expression/expression_node.hpp"
#include "expression/expression_parser.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {
namespace {

/// Precedence of an operation; operands of lower precedence need parentheses.
enum Binding : int {
  kLogic = 1,
  kComparison = 3,
  kSum = 4,
  kProduct = 5,
  kSign = 6,
  kPowerOf = 7,
  kAtom = 8
};

struct Operator {
  const char* symbol = nullptr;
  int binding = kAtom;
};

Operator operator_of(Operation operation) {
  switch (operation) {
    case Operation::kOr:
      return {" || ", kLogic};
    case Operation::kAnd:
      return {" && ", kLogic + 1};
    case Operation::kLess:
      return {" < ", kComparison};
    case Operation::kLessEqual:
      return {" <= ", kComparison};
    case Operation::kEqual:
      return {" == ", kComparison};
    case Operation::kAdd:
      return {" + ", kSum};
    case Operation::kSubtract:
      return {" - ", kSum};
    case Operation::kMultiply:
    case Operation::kLimitProduct:
      return {"*", kProduct};
    case Operation::kDivide:
      return {"/", kProduct};
    case Operation::kPower:
      return {"^", kPowerOf};
    default:
      return {};
  }
}

std::string name_text(const std::string& name) {
  TextMatch match;
  return is_plain_name(name) || is_text_match(name, match) ? name : fmt::format("`{}`", name);
}

std::string number_text(double value) {
  if (std::isnan(value)) return "(0/0)";
  if (std::isinf(value)) return value > 0 ? "(1/0)" : "(-1/0)";
  const std::string digits = shortest(value);
  return std::signbit(value) ? fmt::format("({})", digits) : digits;
}

std::string render(const NodePointer& node, int least_binding);

std::string call_text(const NodePointer& node) {
  std::string text(function_name(node->operation));
  for (int i = 0; i < node->operand_count; ++i) {
    text += (i == 0 ? "(" : ", ") + render(node->operands[i], 0);
  }
  return text + ")";
}

std::string operator_text(const NodePointer& node, const Operator& infix) {
  // Left-associative except powers; comparisons do not associate.
  const bool is_power = node->operation == Operation::kPower;
  const bool is_comparison = infix.binding == kComparison;
  const int left = infix.binding + (is_power || is_comparison ? 1 : 0);
  const int right = is_power ? kSign : infix.binding + 1;
  return fmt::format(
      "{}{}{}", render(node->operands[0], left), infix.symbol, render(node->operands[1], right));
}

std::string prefix_text(const NodePointer& node, int least_binding) {
  // -b*x reads as (-b)*x, which is the same and needs no parentheses.
  const NodePointer& operand = node->operands[0];
  const bool is_negate = node->operation == Operation::kNegate;
  const bool takes_product = is_negate && operator_of(operand->operation).binding == kProduct;
  const int binding = takes_product ? kProduct : kSign;
  const std::string text = fmt::format("{}{}", is_negate ? "-" : "!", render(operand, binding));
  return binding < least_binding ? fmt::format("({})", text) : text;
}

std::string render(const NodePointer& node, int least_binding) {
  if (node->operation == Operation::kConstant) return number_text(node->value);
  if (node->operation == Operation::kVariable) {
    TextMatch match;
    const std::string text = name_text(node->name);
    return is_text_match(node->name, match) && least_binding > kComparison ? '(' + text + ')'
                                                                           : text;
  }
  if (node->operation == Operation::kNegate || node->operation == Operation::kNot) {
    return prefix_text(node, least_binding);
  }
  // The mark of an expression with limits is not a part of it.
  if (node->operation == Operation::kLimitProduct && is_constant(node->operands[0], 1.0)) {
    return render(node->operands[1], least_binding);
  }
  const Operator infix = operator_of(node->operation);
  if (infix.symbol == nullptr) return call_text(node);
  const std::string text = operator_text(node, infix);
  return infix.binding < least_binding ? fmt::format("({})", text) : text;
}

/// Text with no more parentheses than needed, which parses to the same graph.
std::string text_of(const NodePointer& node) { return render(node, 0); }

/// Rebuilds a graph with one variable replaced, simplifying again.
class Substitution {
 public:
  Substitution(std::string_view name, NodePointer replacement)
      : name_(name), replacement_(std::move(replacement)) {}

  NodePointer of(const NodePointer& node) {
    if (node->operation == Operation::kVariable) return node->name == name_ ? replacement_ : node;
    if (node->operand_count == 0) return node;
    const auto known = results_.find(node.get());
    if (known != results_.end()) return known->second;
    NodePointer result = rebuilt(node);
    results_.emplace(node.get(), result);
    return result;
  }

 private:
  NodePointer rebuilt(const NodePointer& node) {
    const NodePointer a = of(node->operands[0]);
    if (node->operand_count == 1) return make_operation(node->operation, a);
    const NodePointer b = of(node->operands[1]);
    if (node->operand_count == 2) return make_operation(node->operation, a, b);
    return make_operation(node->operation, a, b, of(node->operands[2]));
  }

  std::string_view name_;
  NodePointer replacement_;
  std::unordered_map<const ExpressionNode*, NodePointer> results_;
};

/// Whether the derivative of an operation jumps at some values of its arguments.
bool has_kink(Operation operation) {
  switch (operation) {
    case Operation::kAbs:
    case Operation::kSign:
    case Operation::kMin:
    case Operation::kMax:
    case Operation::kLess:
    case Operation::kLessEqual:
    case Operation::kEqual:
    case Operation::kAnd:
    case Operation::kOr:
    case Operation::kNot:
      return true;
    default:
      return false;
  }
}

/// Which parts of a graph depend on a variable.
class Dependence {
 public:
  explicit Dependence(std::string_view name) : name_(name) {}

  bool of(const NodePointer& node) {
    if (node->operation == Operation::kVariable) return node->name == name_;
    const auto known = results_.find(node.get());
    if (known != results_.end()) return known->second;
    bool result = false;
    for (int i = 0; i < node->operand_count; ++i) result = of(node->operands[i]) || result;
    results_.emplace(node.get(), result);
    return result;
  }

 private:
  std::string_view name_;
  std::unordered_map<const ExpressionNode*, bool> results_;
};

/// The value of a graph for given variables; shared parts are computed once.
class Valuation {
 public:
  Valuation(const std::vector<std::string>& names, const std::vector<double>& values)
      : names_(names), values_(values) {}

  double of(const NodePointer& node) {
    if (node->operation == Operation::kConstant) return node->value;
    if (node->operation == Operation::kVariable) return of_variable(node->name);
    const auto known = results_.find(node.get());
    if (known != results_.end()) return known->second;
    std::array<double, 3> arguments{};
    for (int i = 0; i < node->operand_count; ++i) arguments[i] = of(node->operands[i]);
    const double result = apply(node->operation, arguments[0], arguments[1], arguments[2]);
    results_.emplace(node.get(), result);
    return result;
  }

 private:
  double of_variable(const std::string& name) const {
    const auto found = std::ranges::find(names_, name);
    if (found == names_.end()) throw UsageError(fmt::format("no value for '{}'", name));
    return values_[static_cast<std::size_t>(found - names_.begin())];
  }

  const std::vector<std::string>& names_;
  const std::vector<double>& values_;
  std::unordered_map<const ExpressionNode*, double> results_;
};

}  // namespace

Expression::Expression(std::shared_ptr<const ExpressionNode> node) : node_(std::move(node)) {}

Expression Expression::parse(std::string_view text) { return parse(text, 0, text.size()); }

Expression Expression::parse(std::string_view whole, std::size_t begin, std::size_t end) {
  return Expression(parse_part(whole, begin, end));
}

Expression Expression::constant(double value) { return Expression(make_constant(value)); }

Expression Expression::variable(std::string_view name) {
  return Expression(make_variable(std::string(name)));
}

std::vector<std::string> Expression::variables() const {
  std::vector<std::string> names;
  for_each_node(node_, [&names](const ExpressionNode& node) {
    if (node.operation != Operation::kVariable) return;
    if (std::ranges::find(names, node.name) == names.end()) names.push_back(node.name);
  });
  return names;
}

Expression Expression::derivative(std::string_view name) const {
  return Expression(differentiate(node_, name));
}

Expression Expression::with_limits() const { return Expression(marked_for_limits(node_)); }

std::vector<Expression> Expression::periodic_arguments() const {
  std::vector<Expression> result;
  for_each_node(node_, [&result](const ExpressionNode& node) {
    if (node.operation != Operation::kSin && node.operation != Operation::kCos &&
        node.operation != Operation::kTan) {
      return;
    }
    result.push_back(Expression(node.operands[0]));
  });
  return result;
}

Expression Expression::substitute(std::string_view name, const Expression& replacement) const {
  return Expression(Substitution(name, replacement.node_).of(node_));
}

bool Expression::has_kink_in(std::string_view name) const {
  Dependence dependence(name);
  bool result = false;
  for_each_node(node_, [&](const ExpressionNode& node) {
    if (node.operation == Operation::kIfElse) {
      result = result || dependence.of(node.operands[0]);
    } else if (has_kink(node.operation)) {
      for (int i = 0; i < node.operand_count; ++i) {
        result = result || dependence.of(node.operands[i]);
      }
    }
  });
  return result;
}

bool Expression::is_constant() const { return node_->operation == Operation::kConstant; }

bool Expression::is_zero() const { return data::is_constant(node_, 0.0); }

double Expression::constant_value() const {
  if (!is_constant()) throw UsageError(fmt::format("'{}' is not a constant", text()));
  return node_->value;
}

double Expression::value(const std::vector<std::string>& names,
                         const std::vector<double>& values) const {
  return Valuation(names, values).of(node_);
}

std::string Expression::text() const { return text_of(node_); }

namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return text;
}

[[noreturn]] void refuse_left_side(std::string_view text, std::string_view left) {
  if (left.empty()) throw FormulaError("expected the column of the response left of ~", text, 1);
  throw FormulaError(
      fmt::format("the left side has to be a column or an expression of columns, not '{}'", left),
      text,
      1);
}

/// The name of the column left of ~, or the text of the expression.
std::string left_side(std::string_view text, std::size_t tilde) {
  const std::string_view left = trimmed(text.substr(0, tilde));
  std::optional<Expression> expression;
  try {
    expression = Expression::parse(text, 0, tilde);
  } catch (const FormulaError&) {
    refuse_left_side(text, left);
  }
  const std::vector<std::string> names = expression->variables();
  if (names.empty()) refuse_left_side(text, left);
  const bool is_name = expression->node()->operation == Operation::kVariable;
  return is_name ? names[0] : std::string(left);
}

}  // namespace

Formula parse_formula(std::string_view text) {
  const std::size_t tilde = text.find('~');
  if (tilde == std::string_view::npos) {
    throw FormulaError(
        "a formula has the form `response ~ expression`; the ~ is missing", text, text.size() + 1);
  }
  return {.left = left_side(text, tilde),
          .right = Expression::parse(text, tilde + 1, text.size()),
          .text = std::string(text)};
}

bool is_text_match(std::string_view variable, TextMatch& match) {
  constexpr std::string_view kBetween = " == \"";
  const std::size_t at = variable.find(kBetween);
  if (at == std::string_view::npos || variable.back() != '"') return false;
  match.column = variable.substr(0, at);
  const std::size_t begin = at + kBetween.size();
  match.value = variable.substr(begin, variable.size() - 1 - begin);
  return true;
}

Expression operator+(const Expression& a, const Expression& b) {
  return Expression(make_operation(Operation::kAdd, a.node(), b.node()));
}

Expression operator-(const Expression& a, const Expression& b) {
  return Expression(make_operation(Operation::kSubtract, a.node(), b.node()));
}

Expression operator*(const Expression& a, const Expression& b) {
  return Expression(make_operation(Operation::kMultiply, a.node(), b.node()));
}

Expression operator*(double a, const Expression& b) { return Expression::constant(a) * b; }

Expression operator-(const Expression& a) {
  return Expression(make_operation(Operation::kNegate, a.node()));
}

Expression exp(const Expression& a) {
  return Expression(make_operation(Operation::kExp, a.node()));
}

Expression log(const Expression& a) {
  return Expression(make_operation(Operation::kLog, a.node()));
}

}  // namespace silvafit::data
