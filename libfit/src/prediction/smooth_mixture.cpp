// SPDX-License-Identifier: MIT
#include "prediction/smooth_mixture.hpp"

#include <array>
#include <cmath>

namespace silvafit::fit {
namespace {

// Standard deviation of the part that the components take, and the distance of the points. By
// Poisson's summation formula the density of u ripples by 2 exp(-2 pi^2 w^2 (1 - w^2) / d^2), one
// part in 10^5, and its distribution function by d / (2 pi) of that.
constexpr double kWidth = 0.2;
constexpr double kDistance = 0.25;
// Points on each side; with 5.75 standard deviations, less than one part in 10^7 is left out.
constexpr Index kSide = 23;

// Weights of the two neighbors of a point in a rule that has the first three moments of the part
// that the components take.
constexpr double kNeighbor = 0.5 * kWidth * kWidth / (kDistance * kDistance);

/// The trapezoid rule for a normal variable.
QuadratureRule spaced_rule(double variance) {
  constexpr Index kCount = 2 * kSide + 3;  // with the outermost ones, which are neighbors only
  QuadratureRule rule{.nodes = MatrixXd(1, kCount), .weights = VectorXd::Zero(kCount)};
  for (Index k = 0; k < kCount; ++k) {
    const double u = kDistance * static_cast<double>(k - kSide - 1);
    rule.nodes(0, k) = u;
    if (k == 0 || k == kCount - 1) continue;
    rule.weights[k] = std::exp(-0.5 * u * u / variance);
  }
  rule.weights /= rule.weights.sum();
  return rule;
}

}  // namespace

QuadratureRule product_rule(const QuadratureRule& first, const QuadratureRule& others) {
  const Index own = first.nodes.rows();
  const Index rest = others.nodes.rows();
  const Index count = first.weights.size() * others.weights.size();
  QuadratureRule rule{.nodes = MatrixXd(own + rest, count), .weights = VectorXd(count)};
  for (Index i = 0, k = 0; i < first.weights.size(); ++i) {
    for (Index j = 0; j < others.weights.size(); ++j, ++k) {
      rule.nodes.col(k).head(own) = first.nodes.col(i);
      rule.nodes.col(k).tail(rest) = others.nodes.col(j);
      rule.weights[k] = first.weights[i] * others.weights[j];
    }
  }
  return rule;
}

QuadratureRule dense_rule(const QuadratureRule& others) {
  return product_rule(spaced_rule(1.0), others);
}

QuadratureRule gapless_rule(const QuadratureRule& others) {
  return product_rule(spaced_rule(1.0 - kWidth * kWidth), others);
}

void close_gaps(Eigen::Ref<VectorXd> means, Eigen::Ref<VectorXd> deviations, Index stride) {
  const VectorXd mean = means;
  const VectorXd variance = deviations.array().square();
  constexpr std::array kWeights{kNeighbor, 1.0 - 2.0 * kNeighbor, kNeighbor};
  for (Index k = stride; k < mean.size() - stride; ++k) {
    // Differences from the point itself, so that large means do not cancel.
    const std::array<double, 3> change{mean[k - stride] - mean[k], 0.0, mean[k + stride] - mean[k]};
    const std::array<double, 3> within{variance[k - stride], variance[k], variance[k + stride]};
    double shift = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      shift += kWeights[i] * change[i];
      square += kWeights[i] * (change[i] * change[i] + within[i]);
    }
    if (!std::isfinite(square)) continue;
    means[k] = mean[k] + shift;
    deviations[k] = std::sqrt(square - shift * shift);
  }
}

}  // namespace silvafit::fit
