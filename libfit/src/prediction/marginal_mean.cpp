// SPDX-License-Identifier: MIT
#include "prediction/marginal_mean.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "marginal_likelihood/quadrature_rule.hpp"
#include "model/covariance_factor.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Points of a rule in all variables together; more would take minutes for 1e5 trees.
constexpr double kMostNodes = 20000.0;

/// Columns of a root that are not zero.
MatrixXd without_zeros(const MatrixXd& root) {
  std::vector<Index> kept;
  for (Index k = 0; k < root.cols(); ++k) {
    if (!root.col(k).isZero(0.0)) kept.push_back(k);
  }
  return root(Eigen::all, kept);
}

/// Arguments moved by b.
MatrixXd moved(const RowMean& mean, const MatrixXd& arguments, const VectorXd& b) {
  MatrixXd result = arguments;
  for (Index j = 0; j < b.size(); ++j) {
    if (b[j] != 0.0) result.col(mean.parameter_of(j)).array() += b[j] * mean.multiplier(j);
  }
  return result;
}

MarginalMean with_rule(const RowMean& mean,
                       const MatrixXd& arguments,
                       const MatrixXd& root,
                       int points,
                       bool with_gradient) {
  const QuadratureRule rule = gauss_hermite(points, root.cols());
  MarginalMean result{.value = VectorXd::Zero(mean.rows())};
  if (with_gradient) result.gradient.setZero(mean.rows(), mean.coefficient_count());
  for (Index k = 0; k < rule.weights.size(); ++k) {
    const MatrixXd at = moved(mean, arguments, root * rule.nodes.col(k));
    result.value += rule.weights[k] * mean.mean(at);
    if (!with_gradient) continue;
    const MatrixXd slopes = mean.gradient(at);
    for (Index j = 0; j < mean.coefficient_count(); ++j) {
      result.gradient.col(j).array() +=
          rule.weights[k] * slopes.col(mean.parameter_of(j)).array() * mean.multiplier(j);
    }
  }
  return result;
}

double largest_difference(const VectorXd& a, const VectorXd& b) {
  double largest = 0.0;
  for (Index i = 0; i < a.size(); ++i) {
    const double size = std::max(std::abs(a[i]), 1e-300);
    if (std::isfinite(a[i])) largest = std::max(largest, std::abs(a[i] - b[i]) / size);
  }
  return largest;
}

}  // namespace

MarginalMean marginal_mean(const RowMean& mean,
                           const MatrixXd& arguments,
                           const MatrixXd& covariance,
                           double accuracy,
                           bool with_gradient) {
  const MatrixXd root = without_zeros(covariance_factor(covariance));
  if (root.cols() == 0) {
    return with_rule(mean, arguments, MatrixXd::Zero(root.rows(), 1), 1, with_gradient);
  }
  constexpr std::array kPoints{3, 5, 7, 11, 15, 21, 31, 45, 63, 91};
  VectorXd last;
  double difference = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < kPoints.size(); ++k) {
    VectorXd value = with_rule(mean, arguments, root, kPoints[k], false).value;
    if (last.size() > 0) difference = largest_difference(value, last);
    last = std::move(value);
    const bool is_last = k + 1 == kPoints.size() ||
                         std::pow(kPoints[k + 1], static_cast<double>(root.cols())) > kMostNodes;
    if (difference > accuracy && !is_last) continue;
    MarginalMean result{.value = std::move(last), .difference = difference};
    if (with_gradient) {
      result.gradient = with_rule(mean, arguments, root, kPoints[k], true).gradient;
    }
    return result;
  }
  return {};
}

}  // namespace silvafit::fit
