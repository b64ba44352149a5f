// SPDX-License-Identifier: MIT
// Workbooks as sources of tables.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/source/open_table.hpp"
#include "source_kind.hpp"

namespace silvafit::source {

/// open_table() for a workbook that is read without GDAL.
OpenedTable open_workbook(const std::string& name,
                          const SourceKind& kind,
                          const TableChoice& choice);

/// The same for the bytes of a file.
OpenedTable read_workbook(std::string_view bytes,
                          const std::string& file,
                          const SourceKind& kind,
                          const std::string& layer);

}  // namespace silvafit::source
