// SPDX-License-Identifier: MIT
#include "silvafit/base/median.hpp"

#include <algorithm>
#include <cassert>

namespace silvafit {

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace silvafit
