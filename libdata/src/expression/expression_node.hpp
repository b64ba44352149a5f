// SPDX-License-Identifier: MIT
// The graph behind an expression, and constructors that simplify as they build.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "expression/operation.hpp"

namespace silvafit::data {

struct ExpressionNode;
using NodePointer = std::shared_ptr<const ExpressionNode>;

/// One operation on up to three operands; immutable, and shared wherever it occurs again.
struct ExpressionNode {
  Operation operation = Operation::kConstant;
  double value = 0.0;                     ///< of a constant
  std::string name{};                     ///< of a variable
  std::array<NodePointer, 3> operands{};  ///< the first `operand_count` are set
  int operand_count = 0;
  int depth = 1;  ///< nodes on the longest path to a variable or constant, itself included
};

/// The largest depth of a graph. All functions on graphs, and the destructor of a node, recur over
/// the operands: with at most 1 KiB of a stack for each level, they need 1 MiB, a quarter of the
/// stack of TBB's threads. A sub-model of 400 coefficients has a depth of about 400.
constexpr int kDeepestExpression = 1000;

NodePointer make_constant(double value);
NodePointer make_variable(std::string name);

/// An operation on operands, simplified where that is exact for finite operands: constants are
/// folded, zeros and ones absorbed, small powers written as products.
/// \throws UsageError if the graph becomes deeper than kDeepestExpression
NodePointer make_operation(Operation operation, const NodePointer& a);
NodePointer make_operation(Operation operation, const NodePointer& a, const NodePointer& b);
NodePointer make_operation(Operation operation,
                           const NodePointer& a,
                           const NodePointer& b,
                           const NodePointer& c);

bool is_constant(const NodePointer& node, double value);

/// A product for derivatives at the boundary of a domain; see Operation::kLimitProduct.
NodePointer make_limit_product(const NodePointer& a, const NodePointer& b);

/// The same value, as an expression whose derivatives use such products. Constants do not change.
NodePointer marked_for_limits(const NodePointer& node);
bool is_marked_for_limits(const NodePointer& node);

/// Visits every node of a graph once, operands from left to right, without recursion.
template <class Visit>
void for_each_node(const NodePointer& root, Visit visit) {
  std::unordered_set<const ExpressionNode*> seen;
  std::vector<const ExpressionNode*> pending{root.get()};
  while (!pending.empty()) {
    const ExpressionNode* node = pending.back();
    pending.pop_back();
    if (!seen.insert(node).second) continue;
    visit(*node);
    for (int i = node->operand_count - 1; i >= 0; --i) pending.push_back(node->operands[i].get());
  }
}

}  // namespace silvafit::data
