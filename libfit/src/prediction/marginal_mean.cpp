// SPDX-License-Identifier: MIT
#include "prediction/marginal_mean.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "conditional_modes/quadrature_rule.hpp"
#include "prediction/prediction_rules.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// Points of a rule in all variables together; more would take minutes for 1e5 trees.
constexpr double kMostNodes = 20000.0;
// Rules of smooth functions agree far better in the end. They never do at a pole, around which the
// mean does not exist (1/u^2 of a normal u).
constexpr double kUnsettled = 0.01;

/// Arguments moved by b.
MatrixXd moved(const RowMean& mean, const MatrixXd& arguments, const VectorXd& b) {
  MatrixXd result = arguments;
  for (Index j = 0; j < b.size(); ++j) {
    const Index k = mean.design().parameter_of(j);
    for (Index row = 0; row < (b[j] != 0.0 ? result.rows() : 0); ++row) {
      result(row, k) += b[j] * mean.design().multiplier(j, row);
    }
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
  if (with_gradient) result.gradient.setZero(mean.rows(), mean.design().coefficient_count());
  for (Index k = 0; k < rule.weights.size(); ++k) {
    const MatrixXd at = moved(mean, arguments, root * rule.nodes.col(k));
    result.value += rule.weights[k] * mean.mean(at);
    if (!with_gradient) continue;
    const MatrixXd slopes = mean.gradient(at);
    for (Index j = 0; j < mean.design().coefficient_count(); ++j) {
      VectorXd slope = rule.weights[k] * slopes.col(mean.design().parameter_of(j));
      mean.design().differentiate(j, 0, slope.size(), slope.data(), slope.data());
      result.gradient.col(j) += slope;
    }
  }
  return result;
}

/// The means of rows by rules of increasing size. A row keeps the last rule at whose nodes its
/// formula is defined: those of larger rules are farther out and may be outside of its domain.
class RowRules {
 public:
  explicit RowRules(Index rows)
      : value_(VectorXd::Constant(rows, kNaN)),
        difference_(VectorXd::Constant(rows, kInfinity)),
        before_(VectorXd::Constant(rows, 0.0)),
        points_(static_cast<std::size_t>(rows), 0) {}

  /// \returns the largest relative difference from the rule before, for rows with a valid rule
  double take(const VectorXd& next, int points) {
    double largest = 0.0;
    for (Index i = 0; i < next.size(); ++i) {
      if (!std::isfinite(next[i])) continue;
      const double size = std::max(std::abs(next[i]), 1e-300);
      before_[i] = difference_[i];
      difference_[i] = std::isnan(value_[i]) ? kInfinity : std::abs(next[i] - value_[i]) / size;
      value_[i] = next[i];
      points_[static_cast<std::size_t>(i)] = points;
      largest = std::max(largest, difference_[i]);
    }
    return largest;
  }

  const VectorXd& value() const { return value_; }
  /// Takes away the values of rows whose last rules differ.
  void remove_unsettled() {
    for (Index i = 0; i < value_.size(); ++i) {
      const double difference = std::max(difference_[i], std::isinf(before_[i]) ? 0.0 : before_[i]);
      if (difference > kUnsettled) value_[i] = kNaN;
    }
  }
  double largest_difference() const {
    double largest = 0.0;
    for (Index i = 0; i < value_.size(); ++i) {
      if (!std::isnan(value_[i])) largest = std::max(largest, difference_[i]);
    }
    return largest;
  }
  /// Points of the rule of each row, 0 where none is good.
  const std::vector<int>& points() const { return points_; }

 private:
  VectorXd value_;
  VectorXd difference_;
  VectorXd before_;  ///< the difference of the rule before; 0 where there is none
  std::vector<int> points_;
};

/// Derivatives of each row by its own rule; NaN if none is valid.
MatrixXd gradient_by(const RowMean& mean,
                     const MatrixXd& arguments,
                     const MatrixXd& root,
                     const std::vector<int>& points) {
  MatrixXd result = MatrixXd::Constant(mean.rows(), mean.design().coefficient_count(), kNaN);
  for (const int rule : std::set<int>(points.begin(), points.end())) {
    if (rule == 0) continue;
    const MatrixXd gradient = with_rule(mean, arguments, root, rule, true).gradient;
    for (Index i = 0; i < result.rows(); ++i) {
      if (points[static_cast<std::size_t>(i)] == rule) result.row(i) = gradient.row(i);
    }
  }
  return result;
}

}  // namespace

MarginalMean marginal_mean(const RowMean& mean,
                           const MatrixXd& arguments,
                           const MatrixXd& covariance,
                           double accuracy,
                           bool with_gradient) {
  const MatrixXd root = root_without_zeros(covariance);
  if (root.cols() == 0) {
    return with_rule(mean, arguments, MatrixXd::Zero(root.rows(), 1), 1, with_gradient);
  }
  constexpr std::array kPoints{3, 5, 7, 11, 15, 21, 31, 45, 63, 91};
  RowRules rows(mean.rows());
  for (std::size_t k = 0; k < kPoints.size(); ++k) {
    const double difference =
        rows.take(with_rule(mean, arguments, root, kPoints[k], false).value, kPoints[k]);
    const bool is_last = k + 1 == kPoints.size() ||
                         std::pow(kPoints[k + 1], static_cast<double>(root.cols())) > kMostNodes;
    if (is_last || (k > 0 && difference <= accuracy)) break;
  }
  rows.remove_unsettled();
  MarginalMean result{.value = rows.value(), .difference = rows.largest_difference()};
  if (with_gradient) result.gradient = gradient_by(mean, arguments, root, rows.points());
  return result;
}

}  // namespace silvafit::fit
