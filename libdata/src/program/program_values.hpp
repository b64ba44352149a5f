// SPDX-License-Identifier: MIT
// The values that several expressions need, each once.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "expression/expression_node.hpp"
#include "expression/operation.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::data {

inline constexpr std::uint32_t kNone = 0xffffffffU;

/// A value of a program: an operation on earlier values.
struct Value {
  Operation operation = Operation::kConstant;
  std::array<std::uint32_t, 3> operands{kNone, kNone, kNone};
  bool is_scalar = true;
  std::uint32_t input = kNone;  ///< for variables
  double constant = 0.0;
};

/// Numbers the values of several graphs so that equal parts get one number, and moves what it can
/// to scalars: -(s v) becomes (-s) v, and s (t v) becomes (s t) v.
class ValueNumbering {
 public:
  explicit ValueNumbering(std::span<const Program::Input> inputs) : inputs_(inputs) {}

  /// \throws UsageError if the graph has a variable that is no input
  std::uint32_t number(const NodePointer& node);

  /// Operands come before the values computed from them.
  const std::vector<Value>& values() const { return values_; }

 private:
  using Operands = std::array<std::uint32_t, 3>;
  using Key = std::tuple<Operation, Operands, std::uint32_t, std::uint64_t>;

  std::uint32_t described(const ExpressionNode& node);
  std::uint32_t variable(const ExpressionNode& node);
  std::uint32_t combined(Operation operation, Operands operands);
  std::uint32_t negated(std::uint32_t number);
  std::uint32_t scaled(std::uint32_t scalar, std::uint32_t number);
  std::uint32_t find_or_add(const Value& value);
  bool is_scaled(std::uint32_t number) const;

  std::span<const Program::Input> inputs_;
  std::vector<Value> values_{};
  std::unordered_map<const ExpressionNode*, std::uint32_t> by_node_{};
  std::map<Key, std::uint32_t> by_key_{};
};

}  // namespace silvafit::data
