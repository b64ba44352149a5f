// SPDX-License-Identifier: MIT
// Tables as the sheets of a workbook.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {

/// The bytes of a workbook of Excel or OpenDocument, by the ending of the file, with a sheet for
/// each table: numbers in their shortest form, texts as texts, never as formulas. The same tables
/// give the same bytes.
/// \throws UsageError if a table is larger than a sheet may be
std::string workbook_of(const std::vector<Layer>& sheets, const std::filesystem::path& file);

}  // namespace silvafit::source
