// SPDX-License-Identifier: MIT
// Texts without capitals and accents, for comparisons.
#pragma once

#include <string>
#include <string_view>

namespace silvafit {

/// A text in lower case and without accents: `Höhe` is `hohe`. Blanks and signs stay.
/// \param text  UTF-8
std::string folded(std::string_view text);

}  // namespace silvafit
