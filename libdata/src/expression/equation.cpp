// SPDX-License-Identifier: MIT
#include "silvafit/data/equation.hpp"

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>

#include "expression/expression_node.hpp"

namespace silvafit::data {
namespace {

/// Which nodes of a graph contain unknowns; each node is visited once.
class Unknowns {
 public:
  explicit Unknowns(const std::vector<std::string>& names) : names_(names) {}

  bool are_in(const NodePointer& node) {
    if (node->operation == Operation::kVariable) {
      return std::ranges::find(names_, node->name) != names_.end();
    }
    const auto known = results_.find(node.get());
    if (known != results_.end()) return known->second;
    bool result = false;
    for (int i = 0; i < node->operand_count; ++i) result = are_in(node->operands[i]) || result;
    results_.emplace(node.get(), result);
    return result;
  }

 private:
  const std::vector<std::string>& names_;
  std::unordered_map<const ExpressionNode*, bool> results_;
};

/// The x with f(x) = outcome; nothing if f has no inverse.
std::optional<NodePointer> inverse(Operation operation, const NodePointer& outcome) {
  switch (operation) {
    case Operation::kNegate:
      return make_operation(Operation::kNegate, outcome);
    case Operation::kExp:
      return make_operation(Operation::kLog, outcome);
    case Operation::kLog:
      return make_operation(Operation::kExp, outcome);
    case Operation::kLog10:
      return make_operation(Operation::kPower, make_constant(10.0), outcome);
    case Operation::kLog2:
      return make_operation(Operation::kPower, make_constant(2.0), outcome);
    case Operation::kLog1p:
      return make_operation(Operation::kExpm1, outcome);
    case Operation::kExpm1:
      return make_operation(Operation::kLog1p, outcome);
    case Operation::kSqrt:
      return make_operation(Operation::kMultiply, outcome, outcome);
    default:
      return std::nullopt;
  }
}

/// The x with (x o other) = outcome; nothing if there is no inverse.
std::optional<NodePointer> inverse_of_first(Operation operation,
                                            const NodePointer& other,
                                            const NodePointer& outcome) {
  switch (operation) {
    case Operation::kAdd:
      return make_operation(Operation::kSubtract, outcome, other);
    case Operation::kSubtract:
      return make_operation(Operation::kAdd, outcome, other);
    case Operation::kMultiply:
      return make_operation(Operation::kDivide, outcome, other);
    case Operation::kDivide:
      return make_operation(Operation::kMultiply, outcome, other);
    case Operation::kPower:
      return make_operation(Operation::kPower,
                            outcome,
                            make_operation(Operation::kDivide, make_constant(1.0), other));
    default:
      return std::nullopt;
  }
}

/// The x with (other o x) = outcome; nothing if there is no inverse.
std::optional<NodePointer> inverse_of_second(Operation operation,
                                             const NodePointer& other,
                                             const NodePointer& outcome) {
  switch (operation) {
    case Operation::kAdd:
    case Operation::kMultiply:
      return inverse_of_first(operation, other, outcome);
    case Operation::kSubtract:
      return make_operation(Operation::kSubtract, other, outcome);
    case Operation::kDivide:
      return make_operation(Operation::kDivide, other, outcome);
    case Operation::kPower:
      return make_operation(Operation::kDivide,
                            make_operation(Operation::kLog, outcome),
                            make_operation(Operation::kLog, other));
    default:
      return std::nullopt;
  }
}

/// Undoes the outermost operation; false if it has no inverse.
bool undo(NodePointer& part, NodePointer& outcome, Unknowns& unknowns) {
  const ExpressionNode& node = *part;
  if (node.operand_count == 0 || node.operand_count > 2) return false;
  const NodePointer first = node.operands[0];
  std::optional<NodePointer> solved;
  NodePointer inside = first;
  if (node.operand_count == 1) {
    solved = inverse(node.operation, outcome);
  } else if (node.operation == Operation::kMultiply && first == node.operands[1]) {
    solved = make_operation(Operation::kSqrt, outcome);
  } else if (!unknowns.are_in(node.operands[1])) {
    solved = inverse_of_first(node.operation, node.operands[1], outcome);
  } else if (!unknowns.are_in(first)) {
    inside = node.operands[1];
    solved = inverse_of_second(node.operation, first, outcome);
  }
  if (!solved) return false;
  part = inside;
  outcome = *std::move(solved);
  return true;
}

}  // namespace

SolvedEquation solve_for(const Expression& expression,
                         const std::vector<std::string>& names,
                         const Expression& outcome) {
  Unknowns unknowns(names);
  NodePointer part = expression.node();
  NodePointer value = outcome.node();
  if (unknowns.are_in(part)) {
    while (undo(part, value, unknowns)) {
    }
  }
  return {.part = Expression(part), .value = Expression(value)};
}

}  // namespace silvafit::data
