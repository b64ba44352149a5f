// SPDX-License-Identifier: MIT
// The normal cloud model: angles with an uncertain standard deviation.
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
  double low = 0.0;            ///< values outside [low, high] are drawn again, together with En'
  double high = 70.0;
};

/// A value with its membership in the cloud: exp(-(x - Ex)^2 / (2 En'^2)), in (0, 1]; 1 if En' is
/// 0.
struct CloudDrop {
  double value = 0.0;
  double membership = 1.0;
};

/// \throws UsageError if the expectation is not inside the limits, an entropy is negative, or one
/// is larger than the width of the limits, so that most values would be outside
void check(const NormalCloud& cloud);

/// \param cloud  a valid cloud, see check()
CloudDrop draw(const NormalCloud& cloud, Random& random);

/// The number of occurrences of each of n values: s_i = int(n L_i / sum L).
///
/// A value that is an integer except for rounding is taken as an integer. The sum of s_i is 1 to n,
/// because the largest value is at least the mean, 1. If all weights are 0 each value occurs once.
/// \param weights  L_i; finite, >= 0, at least one
/// \throws UsageError if they are not
/// Source: Liu et al. 2022, equation 7.
std::vector<std::size_t> appearances(std::span<const double> weights);

/// The values from which branches draw their angles: `count` drops, each as often as appearances()
/// gives with their memberships as weights.
///
/// The source does not define L_i. It uses the drawn values in equation 6 immediately before
/// equation 7, and 6 gives memberships, while branches and their lengths come only later; L_i is
/// therefore the membership. Angles far from the expectation then occur less often than drawn.
/// \throws UsageError as check(), or if the count is 0
std::vector<double> cloud_angles(const NormalCloud& cloud, std::size_t count, Random& random);

}  // namespace silvafit::tree
