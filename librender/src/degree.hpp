// SPDX-License-Identifier: MIT
// Conversion of degrees.
#pragma once

#include <numbers>

namespace silvafit::render {

/// One degree in radians.
inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace silvafit::render
