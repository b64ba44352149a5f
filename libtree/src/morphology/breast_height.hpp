// SPDX-License-Identifier: MIT
#pragma once

namespace silvafit::tree {

/// Height above the ground at which diameters are measured [m].
inline constexpr double kBreastHeight = 1.3;

}  // namespace silvafit::tree
