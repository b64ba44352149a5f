// SPDX-License-Identifier: MIT
#include "expression/expression_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "expression/expression_parser.hpp"
#include "silvafit/data/expression.hpp"
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

}  // namespace

std::string text_of(const NodePointer& node) { return render(node, 0); }

}  // namespace silvafit::data
