// SPDX-License-Identifier: MIT
// JSON inside an HTML page.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::study {

/// The JSON text in a form that is valid inside an HTML script element: `<`, `>`, `&`, U+2028 and
/// U+2029, which occur only inside texts, become their escapes (`\u003c`). The value does not
/// change.
///
/// \param json  UTF-8
std::string escape_for_script(std::string_view json);

}  // namespace silvafit::study
