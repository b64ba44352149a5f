// SPDX-License-Identifier: MIT
// Values on a regular grid, such as a terrain model.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace silvafit::data {

/// Values at the centers of square or rectangular cells, in rows from north to south.
struct Raster {
  std::string file{};
  double west = 0.0;    ///< x of the first column's centers [m]
  double north = 0.0;   ///< y of the first row's centers [m]
  double step_x = 1.0;  ///< between columns [m], positive
  double step_y = 1.0;  ///< between rows [m], positive
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<float> values{};  ///< columns * rows; NaN where unknown

  double x_of(std::size_t column) const { return west + step_x * static_cast<double>(column); }
  double y_of(std::size_t row) const { return north - step_y * static_cast<double>(row); }
  double value(std::size_t column, std::size_t row) const {
    return static_cast<double>(values[row * columns + column]);
  }
  /// The value at a point, bilinear between centers; in the outer half of the border's cells as at
  /// the nearest centers. NaN outside of the cells, or where a value that it needs is unknown.
  double at(double x, double y) const;
};

}  // namespace silvafit::data
