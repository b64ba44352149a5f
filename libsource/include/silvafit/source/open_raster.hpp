// SPDX-License-Identifier: MIT
// Terrain models of GIS files.
#pragma once

#include <optional>
#include <string>

#include "silvafit/data/raster.hpp"
#include "silvafit/source/coordinate_system.hpp"

namespace silvafit::source {

/// The most cells of a raster: 5 x 5 km of 1 m, in 100 MB of memory.
inline constexpr double kMostCells = 25e6;

/// Reads a GeoTIFF or an ASCII grid with the elevations of a terrain [m], in meters.
/// \param target  system of the trees; none: not known
/// \throws InputError if the file cannot be read, has several bands, more than kMostCells, rows
///   that do not run from west to east, values that are no elevations, another coordinate reference
///   system than the trees, one in degrees or, if that of the trees is not known, not in meters
data::Raster open_raster(const std::string& file, const std::optional<CoordinateSystem>& target);

}  // namespace silvafit::source
