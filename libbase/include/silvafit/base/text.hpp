// SPDX-License-Identifier: MIT
// Text for messages.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit {

/// The text with its control characters as escapes: `\x1b` instead of ESC.
///
/// File names may contain sequences that move a terminal's cursor, change its title or reverse the
/// text direction; in messages they are visible and have no effect. Line ends and tabs are kept.
/// JSON text keeps its value because only JSON's own escapes are added.
/// \param text  UTF-8; C0 and C1 controls (U+0000 to U+001F, U+007F to U+009F) and controls of the
///              direction (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069) are escaped,
///              the others copied
std::string with_visible_controls(std::string_view text);

/// "1 tree has", "131 trees have".
/// \param one   the words after the number 1
/// \param many  the words after other numbers
std::string counted(std::size_t count, std::string_view one, std::string_view many);

/// "a", "a and b", "a, b and c"; empty without names.
/// \param last  the word before the last name
std::string enumerated(const std::vector<std::string>& names, std::string_view last = "and");

}  // namespace silvafit
