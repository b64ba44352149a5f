// SPDX-License-Identifier: MIT
#include "bamboo/cloud_model.hpp"

#include <algorithm>
#include <cmath>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

void check(const NormalCloud& cloud) {
  const auto [ex, en, he, low, high] = cloud;
  if (!(low < high && ex >= low && ex <= high)) {
    throw UsageError("the expectation of a cloud model must be within its limits");
  }
  if (!(en >= 0.0 && he >= 0.0 && en <= high - low && he <= high - low)) {
    throw UsageError(
        "the entropies of a cloud model must be at least 0 and at most the width of its limits");
  }
}

CloudDrop draw(const NormalCloud& cloud, Random& random) {
  for (;;) {
    const double entropy = std::abs(random.normal(cloud.entropy, cloud.hyper_entropy));
    const double value = random.normal(cloud.expectation, entropy);
    if (!(value >= cloud.low && value <= cloud.high)) continue;
    const double off = value - cloud.expectation;
    if (entropy == 0.0 || off == 0.0) return {value, 1.0};
    return {value, std::exp(-0.5 * (off / entropy) * (off / entropy))};
  }
}

std::vector<std::size_t> appearances(std::span<const double> weights) {
  double sum = 0.0;
  for (const double weight : weights) {
    if (!(weight >= 0.0)) throw UsageError("weights must not be negative");
    sum += weight;
  }
  if (weights.empty() || !std::isfinite(sum))
    throw UsageError("weights must be finite, and there must be at least one");
  if (sum == 0.0) return std::vector<std::size_t>(weights.size(), 1);
  std::vector<std::size_t> times;
  times.reserve(weights.size());
  for (const double weight : weights) {
    // Fourteen equal weights give values of 1, some with a rounding error below 1.
    constexpr double kRounding = 1e-9;
    const double share = static_cast<double>(weights.size()) * (weight / sum);
    times.push_back(static_cast<std::size_t>(std::floor(share + kRounding)));
  }
  return times;
}

std::vector<double> cloud_angles(const NormalCloud& cloud, std::size_t count, Random& random) {
  check(cloud);
  std::vector<double> values;
  std::vector<double> memberships;
  for (std::size_t i = 0; i < count; ++i) {
    const CloudDrop drop = draw(cloud, random);
    values.push_back(drop.value);
    memberships.push_back(drop.membership);
  }
  const std::vector<std::size_t> times = appearances(memberships);
  std::vector<double> angles;
  angles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) angles.insert(angles.end(), times[i], values[i]);
  return angles;
}

}  // namespace silvafit::tree
