// SPDX-License-Identifier: MIT
#include "mixture_quantile.hpp"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace silvafit::fit {
namespace {

using Eigen::Index;

/// The distribution function and its density.
struct Distribution {
  double probability = 0.0;
  double density = 0.0;
};

}  // namespace

double mixture_quantile(const Eigen::Ref<const Eigen::VectorXd>& means,
                        const Eigen::Ref<const Eigen::VectorXd>& deviations,
                        const Eigen::Ref<const Eigen::VectorXd>& weights,
                        double probability) {
  const auto is_used = [&](Index k) {
    return std::isfinite(means[k]) && std::isfinite(deviations[k]) && deviations[k] > 0.0;
  };
  constexpr double kFar = 40.0;  // standard deviations, beyond any probability of a double
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double total = 0.0;
  double centre = 0.0;
  double squares = 0.0;
  for (Index k = 0; k < means.size(); ++k) {
    if (!is_used(k)) continue;
    low = std::min(low, means[k] - kFar * deviations[k]);
    high = std::max(high, means[k] + kFar * deviations[k]);
    total += weights[k];
    centre += weights[k] * means[k];
    squares += weights[k] * (means[k] * means[k] + deviations[k] * deviations[k]);
  }
  if (!(total > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  const auto at = [&](double y) {
    Distribution result;
    for (Index k = 0; k < means.size(); ++k) {
      if (!is_used(k)) continue;
      const double z = (y - means[k]) / deviations[k];
      result.probability += weights[k] * 0.5 * std::erfc(-z / std::numbers::sqrt2);
      result.density += weights[k] * std::exp(-0.5 * z * z) / deviations[k];
    }
    result.probability /= total;
    result.density /= total * std::sqrt(2.0 * std::numbers::pi);
    return result;
  };
  // Newton's method from where one normal distribution would have it, kept inside a bracket that
  // shrinks.
  const double deviation =
      std::sqrt(std::max(0.0, squares / total - centre * centre / (total * total)));
  const boost::math::normal_distribution<double> normal;
  constexpr int kSteps = 200;
  constexpr double kAccuracy = 1e-10;
  double y = centre / total + deviation * boost::math::quantile(normal, probability);
  for (int step = 0; step < kSteps; ++step) {
    const Distribution here = at(y);
    const double excess = here.probability - probability;
    (excess > 0.0 ? high : low) = y;
    double next = y - excess / here.density;
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - y) <= kAccuracy * (1.0 + std::abs(y))) return next;
    y = next;
  }
  return y;
}

}  // namespace silvafit::fit
