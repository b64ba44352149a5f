// SPDX-License-Identifier: MIT
#include "prediction/prediction_rules.hpp"

#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "model/symmetric_eigen.hpp"
#include "prediction/smooth_mixture.hpp"
#include "silvafit/base/random.hpp"

namespace silvafit::fit {
namespace {

// Points in the main direction if the residual is wide enough to close the gaps between them, and
// in each other direction.
constexpr int kMainPoints = 15;
constexpr int kFewPoints = 3;
// Many points, by the number of directions: a product of many would take too long.
constexpr std::array kManyPoints{1, 1, 11, 7, 5};
// Maximum number of other directions with a product rule, and the common points of more of them.
constexpr Index kProduct = 3;
constexpr int kSharedPoints = 500;
// Largest changes of the mean, in residual standard deviations per standard deviation of the main
// direction, for which the distribution function has no visible steps with the main points and
// with dense points.
constexpr double kSteepForFew = 0.5;
constexpr double kSteepForDense = 4.0;

/// Points of equal weight, in each variable the middles of parts of equal probability, dealt at
/// random (a Latin hypercube): the error does not grow with the number of variables.
/// Source: McKay, Beckman and Conover 1979, Technometrics 21, 239-245.
QuadratureRule shared_rule(Index width) {
  QuadratureRule rule{.nodes = MatrixXd(width, kSharedPoints),
                      .weights = VectorXd::Constant(kSharedPoints, 1.0 / kSharedPoints)};
  VectorXd scores(kSharedPoints);
  const boost::math::normal_distribution<double> normal;
  for (int k = 0; k < kSharedPoints; ++k) {
    scores[k] = boost::math::quantile(normal, (k + 0.5) / kSharedPoints);
  }
  scores /= std::sqrt(scores.squaredNorm() / kSharedPoints);  // variance 1 in spite of the middles
  Random random(1);
  for (Index j = 0; j < width; ++j) {
    for (std::size_t k = kSharedPoints; k > 1; --k) {
      std::swap(scores[static_cast<Index>(k - 1)], scores[static_cast<Index>(random.below(k))]);
    }
    rule.nodes.row(j) = scores;
  }
  return rule;
}

/// \param width   directions beside the main one
/// \param points  a direction, where they are a product
QuadratureRule rule_of_others(Index width, int points) {
  if (width == 0) return {.nodes = MatrixXd(0, 1), .weights = VectorXd::Ones(1)};
  return width <= kProduct ? gauss_hermite(points, width) : shared_rule(width);
}

}  // namespace

MainPoints points_for(double steepness) {
  if (steepness <= kSteepForFew) return MainPoints::kFew;
  return steepness <= kSteepForDense ? MainPoints::kDense : MainPoints::kGapless;
}

PredictionRule prediction_rule(Index width, MainPoints main, bool many) {
  const auto at = static_cast<std::size_t>(width);
  const int points = many && at < kManyPoints.size() ? kManyPoints[at] : kFewPoints;
  if (width == 0) return {.points = rule_of_others(0, points)};
  const QuadratureRule others = rule_of_others(width - 1, points);
  switch (main) {
    case MainPoints::kFew:
      return {.points = product_rule(gauss_hermite(kMainPoints, 1), others)};
    case MainPoints::kDense:
      return {.points = dense_rule(others)};
    case MainPoints::kGapless:
      break;
  }
  return {.points = gapless_rule(others), .stride = others.weights.size()};
}

MatrixXd root_without_zeros(const MatrixXd& covariance) {
  const MatrixXd root = covariance_factor(covariance);
  std::vector<Index> kept;
  for (Index k = 0; k < root.cols(); ++k) {
    if (!root.col(k).isZero(0.0)) kept.push_back(k);
  }
  return root(Eigen::all, kept);
}

// The reflection that maps the derivatives along the columns to a multiple of the first unit
// vector.
MatrixXd rotated_root(MatrixXd root, const VectorXd& slope) {
  VectorXd mirror = root.transpose() * slope;
  const double length = mirror.norm();
  if (root.cols() < 2 || !(length > 0.0) || !std::isfinite(length)) return root;
  mirror[0] += std::copysign(length, mirror[0]);
  const VectorXd along = 2.0 / mirror.squaredNorm() * (root * mirror);
  root.noalias() -= along * mirror.transpose();
  return root;
}

}  // namespace silvafit::fit
