// SPDX-License-Identifier: MIT
// JSON inside an HTML page.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::study {

/// The JSON text in a form that may stand inside an HTML script element: `<`, `>`, `&`, U+2028 and
/// U+2029, which JSON has inside texts only, become their escapes (`\u003c`). The value stays the
/// same.
///
/// \param json  UTF-8
std::string escape_for_script(std::string_view json);

}  // namespace silvafit::study
