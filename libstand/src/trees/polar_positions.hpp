// SPDX-License-Identifier: MIT
// Positions by azimuth and distance.
#pragma once

#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/tree_columns.hpp"

namespace silvafit::stand {

/// What the values of a column of azimuths or distances can be.
struct PolarColumn {
  double full_circle = 0.0;  ///< of azimuths: 360, or 400 in gon; else 0
  bool is_distance = false;  ///< from the point of an azimuth
};

/// The meaning of a column without a formula of the user; neither of both for all others.
/// \param position  the expression of x or y that reads it; pi/200 of gon
PolarColumn polar_column(const std::string& column,
                         const std::string& position,
                         const std::vector<std::string>& header,
                         const std::vector<std::string>& units,
                         const std::vector<ColumnMapping>& mapped);

/// An azimuth beyond a circle shows that the whole column has another unit.
/// \throws InputError if the value, which may be missing, is not possible
void require_polar(double value, const PolarColumn& column, const Place& place);

}  // namespace silvafit::stand
