// SPDX-License-Identifier: MIT
#include "program_block.hpp"

#include <Eigen/Core>
#include <cmath>

namespace silvafit::data {
namespace {

using Rows = Eigen::Map<const Eigen::ArrayXd>;
using Target = Eigen::Map<Eigen::ArrayXd>;

const double* rows_of(const BlockOperand& operand, const BlockMemory& memory) {
  return operand.kind == BlockOperand::kColumn ? memory.columns[operand.index] + memory.first_row
                                               : memory.registers + operand.index * kBlockRows;
}

/// Calls `compute` with the operand as an array, or as a constant array where it is a scalar.
template <typename Compute>
void with_array(const BlockOperand& operand, const BlockMemory& memory, Compute compute) {
  const auto rows = static_cast<Eigen::Index>(memory.rows);
  if (operand.kind == BlockOperand::kScalar) {
    compute(Eigen::ArrayXd::Constant(rows, memory.scalars[operand.index]));
  } else {
    compute(Rows(rows_of(operand, memory), rows));
  }
}

template <typename Compute>
void binary(const BlockInstruction& instruction, const BlockMemory& memory, Compute compute) {
  with_array(instruction.operands[0], memory, [&](const auto& a) {
    with_array(instruction.operands[1], memory, [&](const auto& b) { compute(a, b); });
  });
}

/// x^y for x > 0 as exp(y log x), which vectorises; other bases go one by one.
template <typename Base, typename Exponent>
void power(const Base& base, const Exponent& exponent, Target& target) {
  if ((base > 0.0).all()) {
    target = (base.log() * exponent).exp();
  } else {
    target = base.binaryExpr(exponent, [](double x, double y) { return std::pow(x, y); });
  }
}

/// Whole powers by multiplication, exact to rounding for any base.
template <typename Base>
void whole_power(const Base& base, int exponent, Target& target) {
  Eigen::ArrayXd factor = base;
  Eigen::ArrayXd result = Eigen::ArrayXd::Ones(target.size());
  for (int rest = std::abs(exponent); rest > 0; rest /= 2) {
    if (rest % 2 == 1) result *= factor;
    factor *= factor;
  }
  target = exponent < 0 ? result.inverse().eval() : result;
}

void execute_power(const BlockInstruction& instruction, const BlockMemory& memory, Target& target) {
  constexpr double kLargestWhole = 64.0;
  const BlockOperand& exponent = instruction.operands[1];
  if (exponent.kind == BlockOperand::kScalar) {
    const double value = memory.scalars[exponent.index];
    if (value == std::round(value) && std::abs(value) <= kLargestWhole) {
      with_array(instruction.operands[0], memory, [&](const auto& base) {
        whole_power(base, static_cast<int>(value), target);
      });
      return;
    }
  }
  binary(instruction, memory, [&](const auto& a, const auto& b) { power(a, b, target); });
}

void execute_one_by_one(const BlockInstruction& instruction,
                        const BlockMemory& memory,
                        Target& target) {
  const auto value_of = [&memory](const BlockOperand& operand, std::size_t row) {
    return operand.kind == BlockOperand::kScalar ? memory.scalars[operand.index]
                                                 : rows_of(operand, memory)[row];
  };
  // Unused operands read scalar 0, which always exists where there is any instruction with a free
  // operand.
  const auto& operands = instruction.operands;
  for (std::size_t row = 0; row < memory.rows; ++row) {
    target[static_cast<Eigen::Index>(row)] = apply(instruction.operation,
                                                   value_of(operands[0], row),
                                                   value_of(operands[1], row),
                                                   value_of(operands[2], row));
  }
}

bool execute_arithmetic(const BlockInstruction& instruction,
                        const BlockMemory& memory,
                        Target& target) {
  switch (instruction.operation) {
    case Operation::kAdd:
      binary(instruction, memory, [&](const auto& a, const auto& b) { target = a + b; });
      return true;
    case Operation::kSubtract:
      binary(instruction, memory, [&](const auto& a, const auto& b) { target = a - b; });
      return true;
    case Operation::kMultiply:
      binary(instruction, memory, [&](const auto& a, const auto& b) { target = a * b; });
      return true;
    case Operation::kDivide:
      binary(instruction, memory, [&](const auto& a, const auto& b) { target = a / b; });
      return true;
    case Operation::kPower:
      execute_power(instruction, memory, target);
      return true;
    default:
      return false;
  }
}

bool execute_function(const BlockInstruction& instruction,
                      const BlockMemory& memory,
                      Target& target) {
  const Rows a(rows_of(instruction.operands[0], memory), static_cast<Eigen::Index>(memory.rows));
  switch (instruction.operation) {
    case Operation::kNegate:
      target = -a;
      return true;
    case Operation::kExp:
      target = a.exp();
      return true;
    case Operation::kLog:
      target = a.log();
      return true;
    case Operation::kSqrt:
      target = a.sqrt();
      return true;
    case Operation::kAbs:
      target = a.abs();
      return true;
    default:
      return false;
  }
}

}  // namespace

void execute(const BlockInstruction& instruction, const BlockMemory& memory) {
  Target target(memory.registers + instruction.target * kBlockRows,
                static_cast<Eigen::Index>(memory.rows));
  if (execute_arithmetic(instruction, memory, target)) return;
  if (instruction.operands[0].kind != BlockOperand::kScalar &&
      execute_function(instruction, memory, target)) {
    return;
  }
  execute_one_by_one(instruction, memory, target);
}

void copy_out(const BlockOperand& operand, const BlockMemory& memory, double* target) {
  with_array(operand, memory, [&](const auto& values) {
    Target(target, static_cast<Eigen::Index>(memory.rows)) = values;
  });
}

}  // namespace silvafit::data
