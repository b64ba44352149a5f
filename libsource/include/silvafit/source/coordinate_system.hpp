// SPDX-License-Identifier: MIT
// The coordinate reference system of positions.
#pragma once

#include <string>

namespace silvafit::source {

/// Positions in meters, and the reference system that they belong to.
struct CoordinateSystem {
  std::string wkt{};             ///< definition in well-known text
  std::string name{};            ///< for messages: `EPSG:32633`, or its name
  double meters_per_unit = 1.0;  ///< positions / this = coordinates of the system
};

}  // namespace silvafit::source
