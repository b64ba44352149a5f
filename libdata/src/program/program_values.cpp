// SPDX-License-Identifier: MIT
#include "program/program_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit::data {
namespace {

bool commutes(Operation operation) {
  return operation == Operation::kAdd || operation == Operation::kMultiply ||
         operation == Operation::kLimitProduct || operation == Operation::kEqual;
}

}  // namespace

std::uint32_t ValueNumbering::number(const NodePointer& node) {
  const auto known = by_node_.find(node.get());
  if (known != by_node_.end()) return known->second;
  const std::uint32_t result = described(*node);
  by_node_.emplace(node.get(), result);
  return result;
}

std::uint32_t ValueNumbering::described(const ExpressionNode& node) {
  if (node.operation == Operation::kConstant) return find_or_add({.constant = node.value});
  if (node.operation == Operation::kVariable) return variable(node);
  Operands operands{kNone, kNone, kNone};
  for (int i = 0; i < node.operand_count; ++i) operands[i] = number(node.operands[i]);
  if (node.operation == Operation::kNegate) return negated(operands[0]);
  if (node.operation == Operation::kMultiply && values_[operands[0]].is_scalar) {
    return scaled(operands[0], operands[1]);
  }
  if (node.operation == Operation::kMultiply && values_[operands[1]].is_scalar) {
    return scaled(operands[1], operands[0]);
  }
  return combined(node.operation, operands);
}

std::uint32_t ValueNumbering::variable(const ExpressionNode& node) {
  const auto found = std::ranges::find(inputs_, node.name, &Program::Input::name);
  if (found == inputs_.end()) {
    throw UsageError(fmt::format("'{}' is neither a column nor a parameter", node.name));
  }
  return find_or_add({.operation = Operation::kVariable,
                      .is_scalar = found->is_scalar,
                      .input = static_cast<std::uint32_t>(found - inputs_.begin())});
}

/// Whether a value is a scalar times or over one that differs by row; the scalar comes first.
bool ValueNumbering::is_scaled(std::uint32_t number) const {
  const Value& value = values_[number];
  return !value.is_scalar &&
         (value.operation == Operation::kMultiply || value.operation == Operation::kDivide) &&
         values_[value.operands[0]].is_scalar;
}

std::uint32_t ValueNumbering::negated(std::uint32_t number) {
  if (!is_scaled(number)) return combined(Operation::kNegate, {number, kNone, kNone});
  const Value value = values_[number];
  return combined(value.operation, {negated(value.operands[0]), value.operands[1], kNone});
}

std::uint32_t ValueNumbering::scaled(std::uint32_t scalar, std::uint32_t number) {
  if (!is_scaled(number)) return combined(Operation::kMultiply, {scalar, number, kNone});
  const Value value = values_[number];
  const std::uint32_t scale = combined(Operation::kMultiply, {scalar, value.operands[0], kNone});
  return combined(value.operation, {scale, value.operands[1], kNone});
}

std::uint32_t ValueNumbering::combined(Operation operation, Operands operands) {
  Value value{.operation = operation, .operands = operands};
  for (const std::uint32_t operand : operands) {
    if (operand != kNone) value.is_scalar = value.is_scalar && values_[operand].is_scalar;
  }
  if (commutes(operation)) {
    // In a fixed order, scalars first.
    const auto rank = [this](std::uint32_t number) {
      return std::pair(!values_[number].is_scalar, number);
    };
    if (rank(operands[1]) < rank(operands[0])) std::swap(value.operands[0], value.operands[1]);
  }
  return find_or_add(value);
}

std::uint32_t ValueNumbering::find_or_add(const Value& value) {
  const Key key{
      value.operation, value.operands, value.input, std::bit_cast<std::uint64_t>(value.constant)};
  const auto [entry, is_new] = by_key_.try_emplace(key, static_cast<std::uint32_t>(values_.size()));
  if (is_new) values_.push_back(value);
  return entry->second;
}

}  // namespace silvafit::data
