// SPDX-License-Identifier: MIT
// Properties of workbooks that GDAL does not report: encryption, damage of the archive, sheets that
// need much memory, and formulas without values.
#pragma once

#include <cstddef>
#include <string>

#include "source_kind.hpp"

namespace silvafit::source {

/// \param place  for messages
/// \throws InputError with the remedy if the file is encrypted, or is not a workbook of its kind
void require_readable_workbook(const std::string& path,
                               const SourceKind& kind,
                               const std::string& place);

/// Reads all parts of a workbook of Excel or OpenDocument once.
/// \return whether cells are behind rows that GDAL ignores (GridScan)
/// \throws InputError if a part is damaged, or the workbook needs much more memory than its size
///   (limits in docs/hardening.md)
bool require_whole_workbook(const std::string& path,
                            const SourceKind& kind,
                            const std::string& place);

/// Cells of a sheet whose formula has no stored value.
struct FormulasWithoutValue {
  std::size_t count = 0;
  std::string first{};  ///< `F5`
};

/// Those of an Excel workbook; programs that do not compute, such as Python's openpyxl, write them.
FormulasWithoutValue formulas_without_value(const std::string& path, const std::string& sheet);

}  // namespace silvafit::source
