// SPDX-License-Identifier: MIT
// Joint distribution of structural classes.
#pragma once

#include <cstddef>
#include <vector>

#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {

/// Proportions of the core trees by the classes 0, 1/n, ..., 1 of two of W, M, U and C, with the
/// weights of the edge correction; NaN if there is no tree.
/// Source: Li and others 2012, Journal of Vegetation Science 23, 1180-1190.
struct JointDistribution {
  std::size_t neighbors = 0;    ///< n; there are n + 1 classes
  std::size_t trees = 0;        ///< core trees that have both indices
  std::vector<double> share{};  ///< (n + 1)^2: rows of the first index; the sum is 1

  double at(std::size_t first_class, std::size_t second_class) const {
    return share[first_class * (neighbors + 1) + second_class];
  }
};

}  // namespace silvafit::stand
