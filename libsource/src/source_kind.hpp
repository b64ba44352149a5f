// SPDX-License-Identifier: MIT
// The kinds of sources, by their names.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace silvafit::source {

/// Properties of the sources with one ending.
struct SourceKind {
  std::string_view ending{};   ///< without its dot, lower case; `PG:` for PostgreSQL
  std::string_view drivers{};  ///< of GDAL, separated by commas; empty: read without GDAL
  std::string_view format{};   ///< for messages
  bool is_workbook = false;
  /// The source has its own SQL; for others GDAL imports the layers into SQLite.
  bool has_own_sql = false;
};

/// All kinds.
std::span<const SourceKind> source_kinds();

/// The kind of a name; nothing if no kind has its ending.
const SourceKind* kind_of_source(std::string_view name);

/// Whether a file with this ending is written as a workbook: xlsx, ods.
bool is_written_as_workbook(const std::filesystem::path& file);

/// The ending of a name in lower case, without its dot.
std::string ending_of(std::string_view name);

}  // namespace silvafit::source
