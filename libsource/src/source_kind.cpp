// SPDX-License-Identifier: MIT
#include "source_kind.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "silvafit/base/words.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/source/write_layers.hpp"

namespace silvafit::source {
namespace {

constexpr std::string_view kPostgres = "PG:";

constexpr std::array<SourceKind, 15> kKinds{{
    {.ending = "xlsx", .format = "an Excel workbook", .is_workbook = true},
    {.ending = "xlsm", .format = "an Excel workbook", .is_workbook = true},
    {.ending = "xls", .drivers = "XLS", .format = "an Excel 97 workbook", .is_workbook = true},
    {.ending = "ods", .format = "an OpenDocument workbook", .is_workbook = true},
    {.ending = "gpkg", .drivers = "GPKG", .format = "a GeoPackage", .has_own_sql = true},
    {.ending = "shp", .drivers = "ESRI Shapefile", .format = "a shapefile"},
    {.ending = "dbf", .drivers = "ESRI Shapefile", .format = "a dBase table"},
    {.ending = "fgb", .drivers = "FlatGeobuf", .format = "a FlatGeobuf file"},
    {.ending = "sqlite",
     .drivers = "SQLite,GPKG",
     .format = "an SQLite database",
     .has_own_sql = true},
    {.ending = "sqlite3",
     .drivers = "SQLite,GPKG",
     .format = "an SQLite database",
     .has_own_sql = true},
    {.ending = "db", .drivers = "SQLite,GPKG", .format = "an SQLite database", .has_own_sql = true},
    {.ending = "geojson", .drivers = "GeoJSON", .format = "a GeoJSON file"},
    {.ending = "geojsonl", .drivers = "GeoJSONSeq", .format = "a GeoJSON sequence"},
    {.ending = "geojsons", .drivers = "GeoJSONSeq", .format = "a GeoJSON sequence"},
    {.ending = kPostgres,
     .drivers = "PostgreSQL",
     .format = "a PostgreSQL database",
     .has_own_sql = true},
}};

bool begins_with_postgres(std::string_view name) {
  return name.size() > 2 && (name.starts_with("PG:") || name.starts_with("pg:"));
}

/// Replaces the value behind `password=` up to the next blank, or the quoted one.
std::string without_password(std::string name) {
  constexpr std::string_view kKey = "password=";
  const std::size_t key = in_lower_case(name).find(kKey);
  if (key != std::string::npos) {
    const std::size_t begin = key + kKey.size();
    const bool is_quoted = begin < name.size() && name[begin] == '\'';
    std::size_t end = is_quoted ? name.find('\'', begin + 1) : name.find(' ', begin);
    if (end != std::string::npos && is_quoted) ++end;
    name.replace(begin, std::min(end, name.size()) - begin, "...");
  }
  // postgresql://user:password@host/database
  const std::size_t scheme = name.find("://");
  const std::size_t at = name.find('@');
  if (scheme == std::string::npos || at == std::string::npos) return name;
  const std::size_t colon = name.find(':', scheme + 3);
  if (colon < at) name.replace(colon + 1, at - colon - 1, "...");
  return name;
}

}  // namespace

std::span<const SourceKind> source_kinds() { return kKinds; }

std::string ending_of(std::string_view name) {
  std::string ending = std::filesystem::path(name).extension().string();
  if (ending.starts_with('.')) ending.erase(0, 1);
  return in_lower_case(ending);
}

const SourceKind* kind_of_source(std::string_view name) {
  const std::string ending = begins_with_postgres(name) ? std::string(kPostgres) : ending_of(name);
  const auto* const found = std::ranges::find(kKinds, ending, &SourceKind::ending);
  return found == kKinds.end() ? nullptr : found;
}

bool is_layered(const std::string& name) { return kind_of_source(name) != nullptr; }

bool is_network_name(const std::string& name) {
  return name.starts_with("/vsi") ||
         (name.find("://") != std::string::npos && !begins_with_postgres(name));
}

std::string shown_name(const std::string& name) {
  return begins_with_postgres(name) ? without_password(name) : name;
}

bool is_written_as_workbook(const std::filesystem::path& file) {
  const std::string ending = ending_of(file.string());
  return ending == "xlsx" || ending == "ods";
}

bool is_written_as_layers(const std::filesystem::path& file) {
  return is_written_as_workbook(file) || has_geometries(file);
}

bool has_geometries(const std::filesystem::path& file) {
  const std::string ending = ending_of(file.string());
  return ending == "gpkg" || ending == "fgb";
}

}  // namespace silvafit::source
