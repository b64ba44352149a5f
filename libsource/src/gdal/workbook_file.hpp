// SPDX-License-Identifier: MIT
// What GDAL does not report of workbooks: encryption, and formulas without values.
#pragma once

#include <string>

#include "source_kind.hpp"

namespace silvafit::source {

/// \param place  for messages
/// \throws InputError if the file is encrypted, or is not of its kind; it says what to do
void require_readable_workbook(const std::string& path,
                               const SourceKind& kind,
                               const std::string& place);

/// Cells of a sheet whose formula has no stored value.
struct FormulasWithoutValue {
  std::size_t count = 0;
  std::string first{};  ///< `F5`
};

/// Those of an Excel workbook; programs that do not compute, such as Python's openpyxl, leave them.
FormulasWithoutValue formulas_without_value(const std::string& path, const std::string& sheet);

}  // namespace silvafit::source
