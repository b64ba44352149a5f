// SPDX-License-Identifier: MIT
// Which vector instructions formulas and sums are computed with.
#pragma once

#include <string>

namespace silvafit::data {

/// The instruction set that the vector code of this library runs on this processor: `AVX-512`,
/// `AVX2 with FMA`, `SSE4`, `NEON`, or `none` where numbers are computed one after the other.
///
/// It can matter for the last digits: sets without fused multiply-add round once more.
std::string vector_instructions();

}  // namespace silvafit::data
