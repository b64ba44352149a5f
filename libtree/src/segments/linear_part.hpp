// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "silvafit/tree/affine_map.hpp"

namespace silvafit::tree {

/// The matrix of an affine map, without its translation.
inline Eigen::Matrix3d linear_part(const AffineMap& map) {
  Eigen::Matrix3d a;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) a(row, column) = map.a[row][column];
  }
  return a;
}

}  // namespace silvafit::tree
