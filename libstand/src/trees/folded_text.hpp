// SPDX-License-Identifier: MIT
// Comparisons of texts without capitals and accents.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/base/folded_text.hpp"

namespace silvafit::stand {

/// As folded(), with letters, digits and characters beyond Latin only: `Plot_ID (new)` is
/// `plotidnew`.
std::string folded_letters(std::string_view text);

/// Whether two codes are the same number, or the same text in upper or lower case.
bool is_same_code(std::string_view left, std::string_view right);

}  // namespace silvafit::stand
