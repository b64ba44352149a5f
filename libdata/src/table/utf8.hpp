// SPDX-License-Identifier: MIT
// Validation of UTF-8.
#pragma once

#include <cstddef>
#include <string_view>

namespace silvafit::data {

/// Offset of the first byte that begins no well-formed UTF-8 sequence (Unicode 15, table 3-7), or
/// npos if the text is UTF-8.
std::size_t first_invalid_utf8(std::string_view text);

}  // namespace silvafit::data
