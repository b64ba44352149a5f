// SPDX-License-Identifier: MIT
// Tables of workbooks, GIS layers and databases.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/source/coordinate_system.hpp"

namespace silvafit::source {

/// The choice of a table of a source.
struct TableChoice {
  std::string layer{};         ///< name of a sheet, layer or table; empty: the only one
  std::string sql{};           ///< a query whose result is the table, instead of a layer
  bool allow_network = false;  ///< names of GDAL's network file systems may be used
};

/// The columns that geometries become.
enum class GeometryUse {
  kPositions,  ///< points give the columns x, y and, if they have elevations, z
  kAreas,      ///< polygons give the column wkt; points x and y, as centers of circles
};

struct OpenedTable {
  data::TableSource table{};
  std::optional<CoordinateSystem> coordinates{};  ///< of x and y; none if not known
  std::vector<std::string> notes{};               ///< conversions, and columns that are not read
};

/// Whether a name is that of a workbook, layer or database: a file that ends in xlsx, xlsm, ods
/// or, to be read with GDAL, xls, gpkg, shp, dbf, fgb, sqlite, sqlite3, db, geojson or geojsonl,
/// or `PG:...`. Everything else is a CSV file.
bool is_layered(const std::string& name);

/// Whether a name is that of a remote or virtual file, which only GDAL can read.
bool is_network_name(const std::string& name);

/// The name of a source without passwords, for messages.
std::string shown_name(const std::string& name);

/// Opens a table.
///
/// Sheets become text, so that titles, rows of units and codes for missing values are treated as
/// those of CSV files; line n is row n of the sheet. Layers and query results become tables with
/// their types; line n is the n-th row. Positions are converted to meters: those of a geographic
/// system, or of one that distorts lengths, are projected to the UTM zone of their center, and
/// those in feet are scaled. A note reports each conversion.
/// \param name    a file, or `PG:` with connection parameters of PostgreSQL
/// \param target  coordinates are converted to this system, as those of windows to that of the
///                trees; none: the layer's own system, or UTM
/// \throws InputError if the source cannot be read, has several tables and none is chosen, or its
///   geometries or coordinate system cannot be used; UsageError if the choice is not possible
OpenedTable open_table(const std::string& name,
                       const TableChoice& choice,
                       GeometryUse use = GeometryUse::kPositions,
                       const std::optional<CoordinateSystem>& target = std::nullopt);

/// The version of GDAL, or nothing if the library was built without it.
std::string gdal_version();

}  // namespace silvafit::source
