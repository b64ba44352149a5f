// SPDX-License-Identifier: MIT
// Matrices of the size of one group's random effects, without heap memory.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Maximum number of random effects of a group, over both groupings; NonlinearModel and the reader
/// of fits refuse more.
inline constexpr int kMostRandomEffects = 12;

using SmallMatrix = Eigen::Matrix<double,
                                  Eigen::Dynamic,
                                  Eigen::Dynamic,
                                  Eigen::ColMajor,
                                  kMostRandomEffects,
                                  kMostRandomEffects>;
using SmallVector =
    Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostRandomEffects, 1>;

}  // namespace silvafit::fit
