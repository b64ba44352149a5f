// SPDX-License-Identifier: MIT
// Text that people are shown.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit {

/// The text with its control characters as escapes: `\x1b` instead of ESC.
///
/// Names in files may hold sequences that move a terminal's cursor or change its title; in messages
/// they are seen and do nothing. Line ends and tabs stay, since messages have lines of their own.
/// \param text  UTF-8; C0 and C1 controls (U+0000 to U+001F, U+007F to U+009F) are escaped, the
///              others copied
std::string with_visible_controls(std::string_view text);

/// "1 tree has", "131 trees have".
/// \param one   what follows the number 1
/// \param many  what follows any other
std::string counted(std::size_t count, std::string_view one, std::string_view many);

}  // namespace silvafit
