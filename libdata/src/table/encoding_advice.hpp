// SPDX-License-Identifier: MIT
// Advice on files that are not UTF-8.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::data {

/// Names the likely encoding and the command that converts the file.
/// \param bytes  of the file, the first that is not UTF-8 among them
/// \param file   for the command
std::string advice_on_encoding(std::string_view bytes, const std::string& file);

/// The same for a file in UTF-16, with or without byte order mark.
/// \param bytes  the first of the file
std::string advice_on_utf16(std::string_view bytes, const std::string& file);

}  // namespace silvafit::data
