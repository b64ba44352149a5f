// SPDX-License-Identifier: MIT
// The median of each coefficient over several fits.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace silvafit::fit {

/// (p) the median of each coefficient; for an even number of fits the upper of the two middle
/// values, so that it is the value of a fit.
/// \param values  (p) lists, of at least one value each
inline Eigen::VectorXd medians(std::vector<std::vector<double>> values) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  for (std::size_t j = 0; j < values.size(); ++j) {
    const auto middle = values[j].begin() + static_cast<std::ptrdiff_t>(values[j].size() / 2);
    std::ranges::nth_element(values[j], middle);
    result[static_cast<Eigen::Index>(j)] = *middle;
  }
  return result;
}

}  // namespace silvafit::fit
