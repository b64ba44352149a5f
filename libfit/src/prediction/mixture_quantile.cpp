// SPDX-License-Identifier: MIT
#include "prediction/mixture_quantile.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace silvafit::fit {
namespace {

using Eigen::Index;

/// The distribution function and its density.
struct Distribution {
  double probability = 0.0;
  double density = 0.0;
};

/// The standard normal distribution function and density by Taylor series around tabulated points,
/// to 1e-12: mixtures need them for hundreds of components at each step.
class NormalTable {
 public:
  static constexpr double kEnd = 8.5;  // less than 1e-16 is behind it

  NormalTable() {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double z = place(k);
      points_[k] = {.probability = 0.5 * std::erfc(-z / std::numbers::sqrt2),
                    .density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi)};
    }
  }
  /// \param z  between -kEnd and kEnd
  Distribution at(double z) const {
    const auto k = static_cast<std::size_t>((z + kEnd + kHalfStep) * kPerUnit);
    const Distribution& near = points_[k];
    const double z0 = place(k);
    const double step = z - z0;
    // Derivatives of the density over the density are Hermite polynomials.
    const double second = z0 * z0 - 1.0;
    const double third = -z0 * (z0 * z0 - 3.0);
    const double integral = 1.0 + step * (-z0 / 2.0 + step * (second / 6.0 + step * third / 24.0));
    const double ratio = 1.0 + step * (-z0 + step * (second / 2.0 + step * third / 6.0));
    return {.probability = near.probability + near.density * step * integral,
            .density = near.density * ratio};
  }

 private:
  static constexpr double kPerUnit = 128.0;
  static constexpr double kHalfStep = 0.5 / kPerUnit;
  static double place(std::size_t k) { return static_cast<double>(k) / kPerUnit - kEnd; }

  std::array<Distribution, static_cast<std::size_t>(2.0 * kEnd * kPerUnit) + 1> points_{};
};

/// The components that count, by their inverse standard deviations.
struct Components {
  std::vector<double> means{};
  std::vector<double> inverses{};
  std::vector<double> weights{};  // add up to 1

  Distribution at(double y) const {
    static const NormalTable normal;
    Distribution result;
    for (std::size_t k = 0; k < means.size(); ++k) {
      const double z = (y - means[k]) * inverses[k];
      if (std::abs(z) >= NormalTable::kEnd) {
        if (z > 0.0) result.probability += weights[k];
        continue;
      }
      const Distribution here = normal.at(z);
      result.probability += weights[k] * here.probability;
      result.density += weights[k] * here.density * inverses[k];
    }
    return result;
  }
};

}  // namespace

double mixture_quantile(const Eigen::Ref<const Eigen::VectorXd>& means,
                        const Eigen::Ref<const Eigen::VectorXd>& deviations,
                        const Eigen::Ref<const Eigen::VectorXd>& weights,
                        double probability) {
  // Components of a product rule whose weights together do not change a tail by one part in 10^6.
  constexpr double kNegligible = 1e-6;
  const double tail = std::min(probability, 1.0 - probability);
  const double least = kNegligible * tail * weights.sum() / static_cast<double>(weights.size());
  constexpr double kFar = 40.0;  // standard deviations, beyond any probability of a double
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double total = 0.0;
  double center = 0.0;
  double squares = 0.0;
  Components used;
  for (Index k = 0; k < means.size(); ++k) {
    const bool is_used =
        std::isfinite(means[k]) && std::isfinite(deviations[k]) && deviations[k] > 0.0;
    if (!is_used || weights[k] < least) continue;
    low = std::min(low, means[k] - kFar * deviations[k]);
    high = std::max(high, means[k] + kFar * deviations[k]);
    total += weights[k];
    center += weights[k] * means[k];
    squares += weights[k] * (means[k] * means[k] + deviations[k] * deviations[k]);
    used.means.push_back(means[k]);
    used.inverses.push_back(1.0 / deviations[k]);
    used.weights.push_back(weights[k]);
  }
  if (!(total > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  for (double& weight : used.weights) weight /= total;
  // Newton's method from where one normal distribution would have it, kept inside a bracket that
  // shrinks.
  const double deviation =
      std::sqrt(std::max(0.0, squares / total - center * center / (total * total)));
  const boost::math::normal_distribution<double> normal;
  constexpr int kSteps = 200;
  constexpr double kAccuracy = 1e-10;
  double y = center / total + deviation * boost::math::quantile(normal, probability);
  for (int step = 0; step < kSteps; ++step) {
    const Distribution here = used.at(y);
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
