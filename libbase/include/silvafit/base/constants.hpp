// SPDX-License-Identifier: MIT
// Constants that many files use.
#pragma once

#include <limits>
#include <numbers>

namespace silvafit {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kTwoPi = 2.0 * std::numbers::pi;
/// Radians in a degree.
inline constexpr double kRadian = std::numbers::pi / 180.0;

}  // namespace silvafit
