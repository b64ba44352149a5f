// SPDX-License-Identifier: MIT
#include "silvafit/data/raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace silvafit::data {
namespace {

/// The centers on both sides of a place along an axis.
struct Between {
  std::size_t first = 0;
  std::size_t second = 0;
  double share = 0.0;  ///< of the second
};

/// \param place  in cells from the first center, within half a cell of the centers
Between between(double place, std::size_t cells) {
  const double inside = std::clamp(place, 0.0, static_cast<double>(cells - 1));
  const auto first = static_cast<std::size_t>(inside);
  const double share = inside - static_cast<double>(first);
  return {first, share > 0.0 ? first + 1 : first, share};
}

bool is_within(double place, std::size_t cells) {
  return place >= -0.5 && place <= static_cast<double>(cells) - 0.5;
}

}  // namespace

double Raster::at(double x, double y) const {
  const double column = (x - west) / step_x;
  const double row = (north - y) / step_y;
  if (!is_within(column, columns) || !is_within(row, rows)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const Between across = between(column, columns);
  const Between down = between(row, rows);
  const auto along = [&](std::size_t of_row) {
    return std::lerp(value(across.first, of_row), value(across.second, of_row), across.share);
  };
  return std::lerp(along(down.first), along(down.second), down.share);
}

}  // namespace silvafit::data
