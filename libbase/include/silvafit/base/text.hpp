// SPDX-License-Identifier: MIT
// Text of others that people are shown.
#pragma once

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

}  // namespace silvafit
