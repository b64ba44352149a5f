// SPDX-License-Identifier: MIT
// The vector instructions that compute formulas and sums.
#pragma once

#include <string>

namespace silvafit::data {

/// The instruction set that this library uses on this processor: `AVX-512`, `AVX2 with FMA`,
/// `SSE4`, `NEON`, or `none` without vector instructions.
///
/// The last digits of results can depend on it: without fused multiply-add, products are rounded
/// separately.
std::string vector_instructions();

}  // namespace silvafit::data
