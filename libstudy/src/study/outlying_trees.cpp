// SPDX-License-Identifier: MIT
#include "study/outlying_trees.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "silvafit/base/median.hpp"

namespace silvafit::study {

using Eigen::Index;
using Eigen::VectorXd;

OutlyingTrees outlying_trees(const VectorXd& standardized) {
  OutlyingTrees result;
  if (standardized.size() == 0 || !standardized.allFinite()) return result;
  constexpr double kFar = 8.0;
  // The upper quartile of the standard normal distribution.
  constexpr double kQuartile = 0.674489750196082;
  const VectorXd sizes = standardized.cwiseAbs();
  const double scale = median({sizes.begin(), sizes.end()}) / kQuartile;
  if (!(scale > 0.0)) return result;
  for (Index i = 0; i < sizes.size(); ++i) {
    if (sizes[i] > kFar * scale) result.observations.push_back(i);
  }
  std::ranges::stable_sort(
      result.observations, std::greater<>(), [&](Index i) { return sizes[i]; });
  double sum = 0.0;
  for (const Index i : result.observations) {
    result.distances.push_back(sizes[i] / scale);
    sum += sizes[i] * sizes[i];
  }
  result.share = sum / sizes.squaredNorm();
  return result;
}

}  // namespace silvafit::study
