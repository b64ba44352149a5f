// SPDX-License-Identifier: MIT
// Matrices of the size of one group's random effects, which need no memory from the heap.
#pragma once

#include <Eigen/Core>

namespace silvafit::fit {

/// The most random effects that one group can have, over both groupings; NonlinearModel and the
/// reader of fits refuse more.
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
