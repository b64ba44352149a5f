// SPDX-License-Identifier: MIT
// The inner loops of a program: one operation on one block of rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "operation.hpp"

namespace silvafit::data {

/// Rows a block: a few dozen registers of this length stay in the first-level cache.
inline constexpr std::size_t kBlockRows = 256;

struct BlockOperand {
  enum Kind : std::uint8_t { kScalar, kColumn, kRegister };
  Kind kind = kScalar;
  std::uint32_t index = 0;
};

struct BlockInstruction {
  Operation operation = Operation::kConstant;
  std::uint32_t target = 0;  ///< register
  std::array<BlockOperand, 3> operands{};
};

/// What the instructions work on: registers of kBlockRows values, scalars, and the rows of the
/// columns.
struct BlockMemory {
  double* registers = nullptr;
  const double* scalars = nullptr;
  std::span<const double* const> columns{};
  std::size_t first_row = 0;
  std::size_t rows = 0;
};

void execute(const BlockInstruction& instruction, const BlockMemory& memory);

/// Writes an operand's values of this block to `target`.
void copy_out(const BlockOperand& operand, const BlockMemory& memory, double* target);

}  // namespace silvafit::data
