// SPDX-License-Identifier: MIT
// The median of a sample.
#pragma once

#include <vector>

namespace silvafit {

/// The median: the middle value of an odd number of values, the mean of the two middle values of an
/// even number.
/// \param values  (N) in any order, none NaN; N > 0
double median(std::vector<double> values);

}  // namespace silvafit
