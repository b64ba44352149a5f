// SPDX-License-Identifier: MIT
// The steps of a program, with the places of their operands and results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "program/program_block.hpp"
#include "program/program_values.hpp"

namespace silvafit::data {

struct BlockCode {
  std::vector<BlockInstruction> instructions{};
  std::vector<std::uint32_t> scalars{};  ///< the scalar values that are needed, operands first
  std::size_t registers = 0;
};

/// The code that writes values[outputs[k]] to output k, row by row.
///
/// Sums with a product become one step, powers of one base share its logarithm. The steps of the
/// first output do not depend on the others, with one exception: log(x) that a power of x shares is
/// rounded from more digits. A step writes to its output where it can, else to a register, which is
/// free again after its last use.
BlockCode block_code(const std::vector<Value>& values, std::span<const std::uint32_t> outputs);

}  // namespace silvafit::data
