// SPDX-License-Identifier: MIT
// Validation of UTF-8, and advice on files in other encodings.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::data {

/// Offset of the first byte that begins no well-formed UTF-8 sequence (Unicode 15, table 3-7), or
/// npos if the text is UTF-8.
std::size_t first_invalid_utf8(std::string_view text);

/// Names the likely encoding and the command that converts the file.
/// \param bytes  of the file, the first that is not UTF-8 among them
/// \param file   for the command
std::string advice_on_encoding(std::string_view bytes, const std::string& file);

/// Whether a text has zero bytes as UTF-16 without byte order mark has them: several, and all as
/// first or all as second byte of a pair.
bool looks_like_utf16(std::string_view text);

/// The same for a file in UTF-16, with or without byte order mark.
/// \param bytes  the first of the file
std::string advice_on_utf16(std::string_view bytes, const std::string& file);

}  // namespace silvafit::data
