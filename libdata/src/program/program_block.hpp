// SPDX-License-Identifier: MIT
// The inner loops of a program: steps on one block of rows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "expression/operation.hpp"

namespace silvafit::data {

/// Rows a block: a few dozen registers of this length stay in the first-level cache.
inline constexpr std::size_t kBlockRows = 256;

/// Doubles from one register to the next: not a power of two, so that the same row of several
/// registers does not use the same lines of the cache.
inline constexpr std::size_t kRegisterStride = kBlockRows + 8;

/// Registers begin at multiples of this many bytes.
inline constexpr std::size_t kRegisterAlignment = 64;

/// What a step computes from its operands a, b, c, d.
enum class Step : std::uint8_t {
  kOperation,         ///< the operation of a formula
  kMultiplyAdd,       ///< a b + c
  kMultiplySubtract,  ///< a b - c
  kSubtractProduct,   ///< c - a b
  kExpOfProduct,      ///< exp(a b)
  kWholePower,        ///< a^b by multiplication, for a scalar b, whole and at most kLargestWhole
  kLogarithmPair,     ///< log a and, as second target, its rounding error
  kPowerOfLogarithm,  ///< a^b where c, d are the logarithm pair of a
  kFlooredLogarithm,  ///< log a where b is its logarithm, finite at 0
  kCopy,              ///< a
};

/// Larger whole exponents go through the logarithm: products would round too often.
inline constexpr double kLargestWhole = 64.0;
bool is_whole_power(double exponent);

struct BlockOperand {
  enum Kind : std::uint8_t { kNothing, kScalar, kColumn, kRegister, kOutput };
  Kind kind = kNothing;
  std::uint32_t index = 0;
};

/// One step. All but kCopy have an operand that differs by row.
struct BlockInstruction {
  Step step = Step::kOperation;
  Operation operation = Operation::kConstant;
  BlockOperand target{};         ///< a register or an output
  BlockOperand second_target{};  ///< of kLogarithmPair
  std::array<BlockOperand, 4> operands{};
};

/// The memory of the instructions: registers of kRegisterStride values, scalars, and the rows of
/// the columns and outputs.
struct BlockMemory {
  double* registers = nullptr;
  const double* scalars = nullptr;
  const double* const* columns = nullptr;
  double* const* outputs = nullptr;
  std::size_t first_row = 0;
  std::size_t rows = 0;
};

/// Runs the instructions on rows 0 .. rows - 1, block by block, with the best instruction set of
/// the processor.
void execute(std::span<const BlockInstruction> instructions,
             const BlockMemory& memory,
             std::size_t rows);

}  // namespace silvafit::data
