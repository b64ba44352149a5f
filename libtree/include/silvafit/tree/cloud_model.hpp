// SPDX-License-Identifier: MIT
// The normal cloud model: angles whose spread is itself uncertain.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "silvafit/base/random.hpp"

namespace silvafit::tree {

/// A normal distribution whose standard deviation is normal, too: En' ~ N(En, He), x ~ N(Ex,
/// |En'|). Without the limits x has the mean Ex, the variance En^2 + He^2 and the fourth central
/// moment 3 (En^4 + 6 En^2 He^2 + 3 He^4).
///
/// Source: the cloud model as Liu et al. 2022 use it for Phyllostachys pubescens, equation 6.
struct NormalCloud {
  double expectation = 50.0;   ///< Ex
  double entropy = 2.0;        ///< En, >= 0
  double hyper_entropy = 1.0;  ///< He, >= 0
  double low = 0.0;            ///< values outside [low, high] are drawn anew, En' with them
  double high = 70.0;
};

/// A value with the degree to which it belongs to the cloud: exp(-(x - Ex)^2 / (2 En'^2)), in (0,
/// 1]; 1 where En' is 0.
struct CloudDrop {
  double value = 0.0;
  double membership = 1.0;
};

/// \throws UsageError if the expectation is not inside the limits, an entropy is negative, or one
/// is larger than the limits are apart, so that most values would fall outside
void check(const NormalCloud& cloud);

/// \param cloud  one that check() lets pass
CloudDrop draw(const NormalCloud& cloud, Random& random);

/// How often each of n values appears: s_i = int(n L_i / sum L).
///
/// A share that is whole but for rounding counts as whole. The sum of s_i is n at most, and never
/// 0: the largest share is at least the mean, 1. Where all weights are 0 each value appears once.
/// \param weights  L_i; finite, >= 0, at least one
/// \throws UsageError if they are not
/// Source: Liu et al. 2022, equation 7.
std::vector<std::size_t> appearances(std::span<const double> weights);

/// The values that branches draw their angles from: `count` drops, each as often as appearances()
/// says with their memberships as weights.
///
/// The source leaves L_i undefined. It puts the drawn values into equation 6 right before equation
/// 7, and 6 gives memberships, while branches with their lengths come only afterwards; so L_i is
/// read as membership. Angles far from the expectation then appear less often than they were drawn.
/// \throws UsageError as check(), or if the count is 0
std::vector<double> cloud_angles(const NormalCloud& cloud, std::size_t count, Random& random);

}  // namespace silvafit::tree
