// SPDX-License-Identifier: MIT
#include "prediction/mixture_quantile.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

/// The distribution function, its density and the density's slope.
struct NormalMixture::Distribution {
  double probability = 0.0;
  double density = 0.0;
  double slope = 0.0;
};

namespace {

/// Without long doubles, which take ten times as long.
using NormalDistribution = boost::math::normal_distribution<
    double,
    boost::math::policies::policy<boost::math::policies::promote_double<false>>>;

struct ValueAndSlope {
  double probability = 0.0;
  double density = 0.0;
};

/// The standard normal distribution function and density by Taylor series around tabulated points,
/// to 1e-12: mixtures need them for hundreds of components at each step.
class NormalTable {
 public:
  static constexpr double kEnd = 8.5;  // the probability beyond is less than 1e-16

  NormalTable() {
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const double z = place(k);
      points_[k] = {.probability = 0.5 * std::erfc(-z / std::numbers::sqrt2),
                    .density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi)};
    }
  }
  /// \param z  between -kEnd and kEnd
  ValueAndSlope at(double z) const {
    const auto k = static_cast<std::size_t>((z + kEnd + kHalfStep) * kPerUnit);
    const ValueAndSlope& near = points_[k];
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

  std::array<ValueAndSlope, static_cast<std::size_t>(2.0 * kEnd * kPerUnit) + 1> points_{};
};

}  // namespace

NormalMixture::NormalMixture(const Values& means,
                             const Values& deviations,
                             const Values& weights,
                             double least_tail) {
  assign(means, deviations, weights, least_tail);
}

void NormalMixture::assign(const Values& means,
                           const Values& deviations,
                           const Values& weights,
                           double least_tail) {
  // Components of a product rule whose weights together do not change a tail by one part in 10^6.
  constexpr double kNegligible = 1e-6;
  const double least =
      kNegligible * least_tail * weights.sum() / static_cast<double>(weights.size());
  constexpr double kFar = 40.0;  // standard deviations, beyond any probability of a double
  double total = 0.0;
  low_ = kInfinity;
  high_ = -low_;
  narrowest_ = low_;
  center_ = 0.0;
  for (std::vector<double>* values : {&means_, &inverses_, &weights_}) {
    values->clear();
    values->reserve(static_cast<std::size_t>(means.size()));
  }
  for (Index k = 0; k < means.size(); ++k) {
    const bool is_used =
        std::isfinite(means[k]) && std::isfinite(deviations[k]) && deviations[k] > 0.0;
    if (!is_used || weights[k] < least) continue;
    low_ = std::min(low_, means[k] - kFar * deviations[k]);
    high_ = std::max(high_, means[k] + kFar * deviations[k]);
    total += weights[k];
    center_ += weights[k] * means[k];
    narrowest_ = std::min(narrowest_, deviations[k]);
    means_.push_back(means[k]);
    inverses_.push_back(1.0 / deviations[k]);
    weights_.push_back(weights[k]);
  }
  if (!(total > 0.0)) return;
  for (double& weight : weights_) weight /= total;
  center_ /= total;
  double variance = 0.0;
  double third = 0.0;
  for (std::size_t k = 0; k < means_.size(); ++k) {
    const double from_center = means_[k] - center_;
    const double deviation = 1.0 / inverses_[k];
    const double square = from_center * from_center;
    const double own = deviation * deviation;
    variance += weights_[k] * (square + own);
    third += weights_[k] * from_center * (square + 3.0 * own);
  }
  deviation_ = std::sqrt(variance);
  // For strongly skewed mixtures the expansion of quantiles is useless.
  skewness_ = std::clamp(third / (variance * deviation_), -1.0, 1.0);
}

NormalMixture::Distribution NormalMixture::at(double y) const {
  static const NormalTable normal;
  Distribution result;
  for (std::size_t k = 0; k < means_.size(); ++k) {
    const double inverse = inverses_[k];
    const double z = std::clamp((y - means_[k]) * inverse, -NormalTable::kEnd, NormalTable::kEnd);
    const ValueAndSlope here = normal.at(z);
    const double density = weights_[k] * here.density * inverse;
    result.probability += weights_[k] * here.probability;
    result.density += density;
    result.slope -= density * z * inverse;
  }
  return result;
}

double NormalMixture::quantile(double probability) const {
  if (means_.empty()) return kNaN;
  // Halley's method for the normal score of the distribution function, which is a straight line for
  // one normal distribution, kept inside a bracket that shrinks. It begins at the quantile of the
  // first terms of the Cornish-Fisher expansion.
  const NormalDistribution normal;
  const double score = boost::math::quantile(normal, probability);
  constexpr int kSteps = 200;
  // Within so few standard deviations of the narrowest component the curvature is small: the error
  // after a step is about its third power.
  constexpr double kShortStep = 5e-3;
  constexpr double kSmallScore = 1e-2;
  // Farther away, the score of a heavy tail is strongly curved, and the probability itself is used.
  constexpr double kNear = 1.0;
  constexpr double kAccuracy = 1e-10;
  double low = low_;
  double high = high_;
  double y = center_ + deviation_ * (score + skewness_ / 6.0 * (score * score - 1.0));
  for (int step = 0; step < kSteps; ++step) {
    const Distribution here = at(y);
    const double excess = here.probability - probability;
    (excess > 0.0 ? high : low) = y;
    double next = y - excess / here.density;
    const double own = here.probability > 0.0 && here.probability < 1.0
                           ? boost::math::quantile(normal, here.probability)
                           : kInfinity;
    const double missing = own - score;
    if (std::abs(missing) <= kNear) {
      const double slope = here.density / boost::math::pdf(normal, own);
      const double newton = missing / slope;
      // The second derivative of the score over twice the first.
      const double bend = 0.5 * (here.slope / here.density + own * slope);
      const double divisor = 1.0 - newton * bend;
      // With strong curvature, Newton's step is longer and safer.
      next = y - (divisor > 0.5 && divisor < 2.0 ? newton / divisor : newton);
    }
    const bool is_inside = next > low && next < high;
    if (!is_inside) next = 0.5 * (low + high);
    const double change = std::abs(next - y);
    const bool is_short = std::abs(missing) <= kSmallScore && change <= kShortStep * narrowest_;
    if (is_inside && is_short) return next;
    if (change <= kAccuracy * (1.0 + std::abs(y))) return next;
    y = next;
  }
  return y;
}

}  // namespace silvafit::fit
