// SPDX-License-Identifier: MIT
// Words without regard to upper and lower case, and lists of words.
#pragma once

#include <string>
#include <string_view>

namespace silvafit {

/// The text with its Latin letters in lower case.
std::string in_lower_case(std::string_view text);

/// Whether two texts differ in upper and lower case only.
bool are_equal_words(std::string_view left, std::string_view right);

/// Whether a list with blanks between its words has a word.
bool has_word(std::string_view list, std::string_view word);

}  // namespace silvafit
