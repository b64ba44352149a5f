// SPDX-License-Identifier: MIT
// Texts without capitals and accents, for comparisons.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::stand {

/// A text in lower case and without accents: `Höhe` is `hohe`. Blanks and signs stay.
/// \param text  UTF-8
std::string folded(std::string_view text);

/// The same with letters, digits and characters beyond Latin only: `Plot_ID (new)` is `plotidnew`.
std::string folded_letters(std::string_view text);

/// Whether two codes are the same number, or the same text in upper or lower case.
bool is_same_code(std::string_view left, std::string_view right);

}  // namespace silvafit::stand
