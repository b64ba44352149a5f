// SPDX-License-Identifier: MIT
#include "silvafit/data/expression_parts.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "expression/expression_node.hpp"
#include "expression/expression_parser.hpp"

namespace silvafit::data {
namespace {

bool is_sum(Operation operation) {
  return operation == Operation::kAdd || operation == Operation::kSubtract;
}

bool is_product(Operation operation) {
  return operation == Operation::kMultiply || operation == Operation::kDivide;
}

/// A sign does not separate the operands of a sum or a product.
const NodePointer& without_sign(const NodePointer& node) {
  const NodePointer* inside = &node;
  while ((*inside)->operation == Operation::kNegate) inside = &(*inside)->operands[0];
  return *inside;
}

/// The operands of nested operations of one kind, from left to right.
template <class IsOfKind>
std::vector<NodePointer> flattened(const NodePointer& root, IsOfKind is_of_kind) {
  std::vector<NodePointer> result;
  std::vector<NodePointer> pending{root};
  while (!pending.empty()) {
    const NodePointer node = pending.back();
    pending.pop_back();
    const NodePointer& inside = without_sign(node);
    if (is_of_kind(inside->operation)) {
      pending.push_back(inside->operands[1]);
      pending.push_back(inside->operands[0]);
    } else {
      result.push_back(inside);
    }
  }
  return result;
}

bool is_variable(const ExpressionNode& node, std::string_view name) {
  return node.operation == Operation::kVariable && node.name == name;
}

/// How often names are mentioned: once, or more often (2). Parts of a graph that are shared count
/// as often as they are used; a square mentions its base once.
std::unordered_map<std::string, std::size_t> mentions_in(const NodePointer& root) {
  std::unordered_map<std::string, std::size_t> mentions;
  std::unordered_map<const ExpressionNode*, int> visits;
  std::vector<const ExpressionNode*> pending{root.get()};
  while (!pending.empty()) {
    const ExpressionNode& node = *pending.back();
    pending.pop_back();
    if (++visits[&node] > 2) continue;
    if (node.operation == Operation::kVariable) ++mentions[node.name];
    const bool is_square =
        node.operation == Operation::kMultiply && node.operands[0] == node.operands[1];
    for (int i = is_square ? 1 : 0; i < node.operand_count; ++i) {
      pending.push_back(node.operands[i].get());
    }
  }
  return mentions;
}

/// Looks for parts without data, from the outermost inwards.
class InseparableSearch {
 public:
  InseparableSearch(const NodePointer& root, const std::vector<std::string>& names)
      : mentions_(mentions_in(root)) {
    names_.insert(names.begin(), names.end());
  }

  std::vector<InseparableNames> of(const NodePointer& root) {
    look_into(root);
    return std::move(result_);
  }

 private:
  bool has_data(const NodePointer& node) {
    if (node->operation == Operation::kVariable) return !names_.contains(node->name);
    const auto known = has_data_.find(node.get());
    if (known != has_data_.end()) return known->second;
    bool result = false;
    for (int i = 0; i < node->operand_count; ++i) result = has_data(node->operands[i]) || result;
    has_data_.emplace(node.get(), result);
    return result;
  }

  /// Reports parts without data that belong together if they mention several names once.
  void report(const std::vector<NodePointer>& parts, Operation joined_by) {
    InseparableNames found;
    std::optional<NodePointer> whole;
    for (const NodePointer& part : parts) {
      const std::size_t before = found.names.size();
      for_each_node(part, [&](const ExpressionNode& node) {
        // The factors of a square are one mention.
        const bool is_single = node.operation == Operation::kVariable && mentions_[node.name] == 1;
        if (is_single && std::ranges::count(found.names, node.name) == 0) {
          found.names.push_back(node.name);
        }
      });
      if (found.names.size() == before) continue;
      whole = whole ? make_operation(joined_by, *whole, part) : part;
    }
    if (found.names.size() < 2) return;
    found.text = Expression(*whole).text();
    result_.push_back(std::move(found));
  }

  void look_into(const NodePointer& node) {
    const Operation kind = without_sign(node)->operation;
    if (is_sum(kind)) return look_into_chain(flattened(node, is_sum), Operation::kAdd);
    if (is_product(kind)) return look_into_chain(flattened(node, is_product), Operation::kMultiply);
    if (!has_data(node)) return report({node}, Operation::kAdd);
    const ExpressionNode& outer = *without_sign(node);
    for (int i = 0; i < outer.operand_count; ++i) look_into(outer.operands[i]);
  }

  void look_into_chain(const std::vector<NodePointer>& operands, Operation joined_by) {
    std::vector<NodePointer> without_data;
    for (const NodePointer& operand : operands) {
      if (has_data(operand)) {
        if (seen_.insert(operand.get()).second) look_into(operand);
      } else {
        without_data.push_back(operand);
      }
    }
    report(without_data, joined_by);
  }

  std::unordered_map<std::string, std::size_t> mentions_;
  std::unordered_set<std::string> names_;
  std::unordered_map<const ExpressionNode*, bool> has_data_;
  std::unordered_set<const ExpressionNode*> seen_;
  std::vector<InseparableNames> result_;
};

}  // namespace

std::vector<Expression> summands(const Expression& expression) {
  struct Signed {
    NodePointer node;
    bool is_negative;
  };
  std::vector<Expression> result;
  std::vector<Signed> pending{{expression.node(), false}};
  while (!pending.empty()) {
    const auto [node, is_negative] = pending.back();
    pending.pop_back();
    if (node->operation == Operation::kNegate) {
      pending.push_back({node->operands[0], !is_negative});
    } else if (is_sum(node->operation)) {
      const bool is_difference = node->operation == Operation::kSubtract;
      pending.push_back({node->operands[1], is_negative != is_difference});
      pending.push_back({node->operands[0], is_negative});
    } else {
      result.emplace_back(is_negative ? make_operation(Operation::kNegate, node) : node);
    }
  }
  return result;
}

std::vector<Expression> factors(const Expression& expression) {
  std::vector<Expression> result;
  for (const NodePointer& factor : flattened(expression.node(), is_product)) {
    result.emplace_back(factor);
  }
  return result;
}

bool is_name(const Expression& expression) {
  TextMatch match;
  return expression.node()->operation == Operation::kVariable &&
         !is_text_match(expression.node()->name, match);
}

NameUse use_of(const Expression& expression, std::string_view name) {
  NameUse use{.mentions = mentions_in(expression.node())[std::string(name)]};
  for_each_node(expression.node(), [&](const ExpressionNode& node) {
    const bool has_base = node.operation == Operation::kPower || node.operation == Operation::kSqrt;
    const int looked_at = is_product(node.operation) ? 2 : has_base ? 1 : 0;
    for (int i = 0; i < looked_at; ++i) {
      if (is_variable(*without_sign(node.operands[i]), name)) use.is_factor_or_base = true;
    }
  });
  return use;
}

std::vector<InseparableNames> inseparable_names(const Expression& expression,
                                                const std::vector<std::string>& names) {
  return InseparableSearch(expression.node(), names).of(expression.node());
}

std::vector<NamePlace> vanished_names(std::string_view formula) {
  std::vector<NamePlace> names;
  const Expression value(parse_part(formula, formula.find('~') + 1, formula.size(), &names));
  std::set<std::string> found;
  for (const std::string& name : value.variables()) {
    TextMatch match;
    found.insert(is_text_match(name, match) ? match.column : name);
  }
  std::erase_if(names, [&](const NamePlace& place) { return found.contains(place.name); });
  return names;
}

}  // namespace silvafit::data
