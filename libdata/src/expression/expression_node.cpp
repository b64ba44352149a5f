// SPDX-License-Identifier: MIT
#include "expression/expression_node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::data {
namespace {

[[noreturn]] void refuse_depth() {
  throw UsageError(
      fmt::format("a formula, or its derivative, applies more than {} operations to the result of "
                  "one another; shorten the formula, or compute a part of it as a column",
                  kDeepestExpression));
}

NodePointer raw(Operation operation, std::array<NodePointer, 3> operands, int count) {
  auto node = std::make_shared<ExpressionNode>();
  node->operation = operation;
  node->operands = std::move(operands);
  node->operand_count = count;
  for (int i = 0; i < count; ++i) {
    node->depth = std::max(node->depth, node->operands[i]->depth + 1);
  }
  if (node->depth > kDeepestExpression) refuse_depth();
  return node;
}

bool is_constant(const NodePointer& node) { return node->operation == Operation::kConstant; }

NodePointer negated(const NodePointer& a) { return make_operation(Operation::kNegate, a); }

NodePointer sum(const NodePointer& a, const NodePointer& b) {
  if (is_constant(a, 0.0)) return b;
  if (is_constant(b, 0.0)) return a;
  if (b->operation == Operation::kNegate) {
    return make_operation(Operation::kSubtract, a, b->operands[0]);
  }
  return raw(Operation::kAdd, {a, b}, 2);
}

NodePointer difference(const NodePointer& a, const NodePointer& b) {
  if (is_constant(b, 0.0)) return a;
  if (is_constant(a, 0.0)) return negated(b);
  if (b->operation == Operation::kNegate) return make_operation(Operation::kAdd, a, b->operands[0]);
  return raw(Operation::kSubtract, {a, b}, 2);
}

NodePointer product(const NodePointer& a, const NodePointer& b) {
  if (is_constant(a, 0.0) || is_constant(b, 0.0)) return make_constant(0.0);
  if (is_constant(a, 1.0)) return b;
  if (is_constant(b, 1.0)) return a;
  if (is_constant(a, -1.0)) return negated(b);
  if (is_constant(b, -1.0)) return negated(a);
  if (a->operation == Operation::kNegate) {
    return negated(make_operation(Operation::kMultiply, a->operands[0], b));
  }
  if (b->operation == Operation::kNegate) {
    return negated(make_operation(Operation::kMultiply, a, b->operands[0]));
  }
  return raw(Operation::kMultiply, {a, b}, 2);
}

NodePointer quotient(const NodePointer& a, const NodePointer& b) {
  if (is_constant(a, 0.0)) return a;
  if (is_constant(b, 1.0)) return a;
  if (a->operation == Operation::kNegate) {
    return negated(make_operation(Operation::kDivide, a->operands[0], b));
  }
  return raw(Operation::kDivide, {a, b}, 2);
}

NodePointer power(const NodePointer& a, const NodePointer& b) {
  if (is_constant(b, 0.0)) return make_constant(1.0);
  if (is_constant(b, 1.0)) return a;
  if (is_constant(b, 2.0)) return make_operation(Operation::kMultiply, a, a);
  if (is_constant(b, -1.0)) return make_operation(Operation::kDivide, make_constant(1.0), a);
  if (is_constant(b, 0.5)) return make_operation(Operation::kSqrt, a);
  return raw(Operation::kPower, {a, b}, 2);
}

}  // namespace

bool is_constant(const NodePointer& node, double value) {
  return node->operation == Operation::kConstant && node->value == value;
}

NodePointer make_limit_product(const NodePointer& a, const NodePointer& b) {
  if (is_constant(a, 0.0) || is_constant(b, 0.0)) return make_constant(0.0);
  if (is_constant(a, 1.0)) return b;
  if (is_constant(b, 1.0)) return a;
  return make_operation(Operation::kLimitProduct, a, b);
}

NodePointer marked_for_limits(const NodePointer& node) {
  if (is_constant(node)) return node;
  return raw(Operation::kLimitProduct, {make_constant(1.0), node}, 2);
}

bool is_marked_for_limits(const NodePointer& root) {
  std::unordered_set<const ExpressionNode*> seen;
  std::vector<const ExpressionNode*> waiting{root.get()};
  while (!waiting.empty()) {
    const ExpressionNode* const node = waiting.back();
    waiting.pop_back();
    if (!seen.insert(node).second) continue;
    if (node->operation == Operation::kLimitProduct) return true;
    for (int k = 0; k < node->operand_count; ++k) waiting.push_back(node->operands[k].get());
  }
  return false;
}

NodePointer make_constant(double value) {
  auto node = std::make_shared<ExpressionNode>();
  node->value = value;
  return node;
}

NodePointer make_variable(std::string name) {
  auto node = std::make_shared<ExpressionNode>();
  node->operation = Operation::kVariable;
  node->name = std::move(name);
  return node;
}

NodePointer make_operation(Operation operation, const NodePointer& a) {
  if (is_constant(a)) return make_constant(apply(operation, a->value, 0.0, 0.0));
  if (operation == Operation::kNegate && a->operation == Operation::kNegate) return a->operands[0];
  return raw(operation, {a}, 1);
}

NodePointer make_operation(Operation operation, const NodePointer& a, const NodePointer& b) {
  if (is_constant(a) && is_constant(b)) {
    return make_constant(apply(operation, a->value, b->value, 0.0));
  }
  switch (operation) {
    case Operation::kAdd:
      return sum(a, b);
    case Operation::kSubtract:
      return difference(a, b);
    case Operation::kMultiply:
      return product(a, b);
    case Operation::kDivide:
      return quotient(a, b);
    case Operation::kPower:
      return power(a, b);
    default:
      return raw(operation, {a, b}, 2);
  }
}

NodePointer make_operation(Operation operation,
                           const NodePointer& a,
                           const NodePointer& b,
                           const NodePointer& c) {
  if (operation == Operation::kIfElse) {
    if (is_constant(a)) return a->value != 0.0 ? b : c;
    if (b == c || (is_constant(b) && is_constant(c, b->value))) return b;
  }
  return raw(operation, {a, b, c}, 3);
}

}  // namespace silvafit::data
