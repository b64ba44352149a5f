// SPDX-License-Identifier: MIT
// Tables as layers of GIS files and as sheets of workbooks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/source/coordinate_system.hpp"

namespace silvafit::source {

/// The source of a layer's geometry.
enum class LayerGeometry {
  kNone,
  kPoints,  ///< the columns x and y [m]
  kAreas,   ///< the column wkt with polygons, which does not become a field
};

/// How QGIS draws a layer by default.
enum class LayerStyle {
  kNone,
  kTreesBySpecies,  ///< circles in proportion to dbh, if there is one, one color a species
  kPlotOutlines,
};

struct Layer {
  std::string name{};
  data::Table table{};
  LayerGeometry geometry = LayerGeometry::kNone;
  LayerStyle style = LayerStyle::kNone;  ///< in GeoPackages
};

/// Whether a file with this ending is written by write_layers: gpkg, fgb, xlsx, ods.
bool is_written_as_layers(const std::filesystem::path& file);

/// Whether such a file can have geometries: gpkg, fgb.
bool has_geometries(const std::filesystem::path& file);

/// \throws UsageError if silvafit was built without GDAL and the file is no workbook
void require_layer_output(const std::filesystem::path& file);

/// Writes a file with one layer or sheet for each table, completely or not at all. A FlatGeobuf
/// file has only the first one. In workbooks texts are texts, also those that look like formulas.
/// \param coordinates  of x, y and wkt
/// \throws UsageError for another ending, as require_layer_output(), or if a table does not fit
/// into
///   a sheet; IoError if the file cannot be written
void write_layers(const std::filesystem::path& file,
                  const std::vector<Layer>& layers,
                  const std::optional<CoordinateSystem>& coordinates);

}  // namespace silvafit::source
