// SPDX-License-Identifier: MIT
#include "silvafit/source/open_raster.hpp"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "gdal/functions.hpp"
#include "gdal/session.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::source {
namespace {

[[noreturn]] void refuse_raster(const std::string& file, const std::string& reason) {
  throw InputError(reason, {.file = file});
}

/// Elevations of land, with some room: the Dead Sea is at -430 m, Mount Everest at 8849 m.
constexpr double kLowestElevation = -500.0;
constexpr double kHighestElevation = 9000.0;
/// ASCII grids without another one have this value where there is none (Esri's format).
constexpr double kNoneOfAsciiGrids = -9999.0;

/// Meters in a unit of the raster's coordinates.
double meters_per_unit_of(GDALDataset& dataset,
                          const std::string& file,
                          const std::optional<CoordinateSystem>& target) {
  const OGRSpatialReference* const system = dataset.GetSpatialRef();
  if (system == nullptr) return target ? target->meters_per_unit : 1.0;
  if (system->IsGeographic()) {
    refuse_raster(file,
                  "the terrain is in degrees; convert it to the coordinates of the trees, such as "
                  "with gdalwarp -t_srs EPSG:32633");
  }
  if (target) {
    OGRSpatialReference of_trees;
    const bool is_read = of_trees.importFromWkt(target->wkt.c_str()) == OGRERR_NONE;
    const std::array<const char*, 3> options{
        "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES", "CRITERION=EQUIVALENT", nullptr};
    if (is_read && !system->IsSame(&of_trees, options.data())) {
      refuse_raster(file,
                    fmt::format("the coordinate reference system of the terrain is not {}, that of "
                                "the trees; convert it with gdalwarp -t_srs",
                                target->name));
    }
  }
  const double meters = system->GetLinearUnits();
  if (meters != 1.0 && !target) {
    refuse_raster(file,
                  "the coordinates of the terrain are not in meters, as those of the trees are; "
                  "convert it with gdalwarp -t_srs");
  }
  return meters;
}

/// \param meters  in a unit of the coordinates; where these are in feet, elevations may be, too
void require_meters(GDALRasterBand& band, double meters, const std::string& file) {
  const std::string_view unit = band.GetUnitType();
  const bool is_likely = unit.empty() && meters == 1.0;
  if (is_likely || unit == "m" || unit == "metre" || unit == "meter") return;
  refuse_raster(file,
                unit.empty()
                    ? "the elevations have no unit, and the coordinates are not in "
                      "meters; if the elevations are, say so with gdal_edit -units m"
                    : fmt::format("the elevations are in '{}'; convert them to meters", unit));
}

/// Values of the band in meters, NaN where there is none.
std::vector<float> values_of_band(GDALRasterBand& band,
                                  bool is_ascii_grid,
                                  const data::Raster& raster) {
  std::vector<float> values(raster.columns * raster.rows);
  const int columns = band.GetXSize();
  const int rows = band.GetYSize();
  if (band.RasterIO(
          GF_Read, 0, 0, columns, rows, values.data(), columns, rows, GDT_Float32, 0, 0, nullptr) !=
      CE_None) {
    refuse_raster(raster.file, "the terrain cannot be read");
  }
  int has_none = 0;
  double none = band.GetNoDataValue(&has_none);
  if (has_none == 0 && is_ascii_grid) {
    none = kNoneOfAsciiGrids;
    has_none = 1;
  }
  const double scale = band.GetScale();
  const double offset = band.GetOffset();
  for (float& value : values) {
    const bool is_none = has_none != 0 && value == static_cast<float>(none);
    value = is_none ? std::numeric_limits<float>::quiet_NaN()
                    : static_cast<float>(offset + scale * static_cast<double>(value));
    if (value < kLowestElevation || value > kHighestElevation) {
      refuse_raster(raster.file,
                    fmt::format("{:g} m is no elevation; if it means an unknown one, say so with "
                                "gdal_translate -a_nodata {:g}",
                                value,
                                value));
    }
  }
  return values;
}

}  // namespace

data::Raster raster_with_gdal(const std::string& file,
                              const std::optional<CoordinateSystem>& target) {
  start_gdal();
  set_network(false);
  const KeptMessages messages;
  // No other file beside it is read.
  const Setting alone("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");
  const std::array<const char*, 3> drivers{"GTiff", "AAIGrid", nullptr};
  const GDALDatasetUniquePtr dataset(GDALDataset::Open(
      file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, drivers.data()));
  if (!dataset) {
    refuse_raster(file,
                  fmt::format("not a GeoTIFF or an ASCII grid that can be read{}{}",
                              messages.errors().empty() ? "" : ": ",
                              messages.errors().empty() ? "" : messages.errors().front()));
  }
  if (dataset->GetRasterCount() != 1) {
    refuse_raster(
        file,
        fmt::format("has {} bands; a terrain has one, the elevations", dataset->GetRasterCount()));
  }
  std::array<double, 6> place{};
  const bool has_place = dataset->GetGeoTransform(place.data()) == CE_None;
  if (!has_place || place[2] != 0.0 || place[4] != 0.0 || !(place[1] > 0.0) || !(place[5] < 0.0)) {
    refuse_raster(file,
                  has_place ? "the rows do not run from west to east, from north to south; convert "
                              "it with gdalwarp"
                            : "has no coordinates");
  }
  GDALRasterBand& band = *dataset->GetRasterBand(1);
  if (static_cast<double>(band.GetXSize()) * band.GetYSize() > kMostCells) {
    refuse_raster(file,
                  fmt::format("has {} x {} cells, more than {:g} million; crop it to the plots, "
                              "such as with gdalwarp -te",
                              band.GetXSize(),
                              band.GetYSize(),
                              1e-6 * kMostCells));
  }
  const double meters = meters_per_unit_of(*dataset, file, target);
  require_meters(band, meters, file);
  data::Raster raster{.file = file,
                      .west = meters * (place[0] + 0.5 * place[1]),
                      .north = meters * (place[3] + 0.5 * place[5]),
                      .step_x = meters * place[1],
                      .step_y = -meters * place[5],
                      .columns = static_cast<std::size_t>(band.GetXSize()),
                      .rows = static_cast<std::size_t>(band.GetYSize())};
  const bool is_ascii_grid = dataset->GetDriverName() == std::string_view("AAIGrid");
  raster.values = values_of_band(band, is_ascii_grid, raster);
  if (messages.has_errors()) refuse_raster(file, "the terrain cannot be read without errors");
  return raster;
}

}  // namespace silvafit::source
