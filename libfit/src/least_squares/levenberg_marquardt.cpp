// SPDX-License-Identifier: MIT
#include "least_squares/levenberg_marquardt.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "least_squares/jacobian_factors.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// A step that gains less than this share of what the linear problem predicts is rejected.
constexpr double kLeastGain = 1e-3;
/// Of the trust region, whose inverse is the damping.
constexpr double kFirstRadius = 1e4;
constexpr double kSmallestRadius = 1e-32;
constexpr double kLargestRadius = 1e16;
/// Of J'J, so that a coefficient without influence is damped, too.
constexpr double kLeastDiagonal = 1e-6;
/// Steps shorter than this share of the coefficients are rounding.
constexpr double kShortestStep = 1e-15;
constexpr int kMostInvalidSteps = 40;

/// Steps are in coefficients that are multiplied by the lengths of the first Jacobian's columns.
class DampedDescent {
 public:
  DampedDescent(ProjectedModel& model, const DescentOptions& options)
      : model_(model), options_(options) {
    for (Index k = 0; k < model.size(); ++k) {
      if (k != options.held) free_.push_back(k);
    }
  }

  Descent run(const VectorXd& nonlinear) {
    Descent result{.sum_of_squares = kInfinity};
    if (!model_.evaluate(nonlinear)) return result;
    point_ = nonlinear;
    keep(result);
    if (free_.empty() || !linearize()) return result;
    while (result.iterations < options_.maximum_iterations && radius_ > kSmallestRadius) {
      ++result.iterations;
      if (compute_step()) {
        invalid_steps_ = 0;
        if (!take_step(result)) break;
      } else {
        if (++invalid_steps_ >= kMostInvalidSteps) break;
        shrink();
      }
    }
    return result;
  }

 private:
  /// The point of the last evaluation becomes the lowest.
  void keep(Descent& result) const {
    result.coefficients = model_.coefficients();
    result.sum_of_squares = model_.residuals().squaredNorm();
  }

  /// The triangle of the Jacobian and the residuals at the point of the last evaluation.
  bool linearize() {
    if (!model_.evaluate_jacobian(jacobian_)) return false;
    if (free_.size() < static_cast<std::size_t>(jacobian_.cols())) {
      jacobian_ = jacobian_(Eigen::all, free_).eval();
    }
    if (lengths_.size() == 0) {
      const VectorXd norms = jacobian_.colwise().norm();
      lengths_ = (norms.array() > 0.0).select(norms, 1.0);
    }
    const Index q = jacobian_.cols();
    const MatrixXd triangle = triangle_of(jacobian_, lengths_, model_.residuals());
    if (!triangle.allFinite()) return false;
    triangle_ = triangle.topLeftCorner(q, q);
    projected_ = triangle.col(q).head(q);
    return true;
  }

  /// \return  false if the step is not finite or gains nothing in the linear problem
  bool compute_step() {
    const Index q = triangle_.cols();
    MatrixXd damped(2 * q, q);
    damped.topRows(q) = triangle_;
    damped.bottomRows(q) =
        (triangle_.colwise().squaredNorm().transpose().cwiseMax(kLeastDiagonal) / radius_)
            .cwiseSqrt()
            .asDiagonal();
    VectorXd right_side = VectorXd::Zero(2 * q);
    right_side.head(q) = -projected_;
    step_ = damped.householderQr().solve(right_side);
    if (!step_.allFinite()) return false;
    const VectorXd change = triangle_ * step_;
    predicted_ = -change.dot(2.0 * projected_ + change);
    return predicted_ > 0.0;
  }

  /// Moves there if the sum of squares becomes lower.
  /// \return  false at the end of the descent
  bool take_step(Descent& result) {
    const VectorXd step = step_.cwiseQuotient(lengths_);
    VectorXd next = point_;
    next(free_) += step;
    const double sum_of_squares =
        model_.evaluate(next) ? model_.residuals().squaredNorm() : kInfinity;
    const double gain = result.sum_of_squares - sum_of_squares;
    const bool is_last = step.norm() <= kShortestStep * (point_.norm() + kShortestStep) ||
                         std::abs(gain) <= options_.tolerance * result.sum_of_squares;
    // A point without derivatives would be the end: such a step is rejected.
    if (!(gain > (is_last ? 0.0 : kLeastGain * predicted_)) || !linearize()) {
      shrink();
      return !is_last;
    }
    keep(result);
    point_ = std::move(next);
    const double quality = gain / predicted_;
    radius_ /= std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * quality - 1.0, 3));
    radius_ = std::min(radius_, kLargestRadius);
    divisor_ = 2.0;
    return !is_last;
  }

  void shrink() {
    radius_ /= divisor_;
    divisor_ *= 2.0;
  }

  ProjectedModel& model_;
  const DescentOptions& options_;
  std::vector<Index> free_;  ///< nonlinear coefficients that are not held
  VectorXd point_;           ///< (q) all nonlinear coefficients
  VectorXd lengths_;         ///< of the columns of the first Jacobian
  MatrixXd jacobian_;
  MatrixXd triangle_;   ///< R of the Jacobian's QR decomposition
  VectorXd projected_;  ///< Q' r
  VectorXd step_;
  double predicted_ = 0.0;  ///< decrease of the linear problem's sum of squares
  double radius_ = kFirstRadius;
  double divisor_ = 2.0;  ///< of the radius at the next rejected step
  int invalid_steps_ = 0;
};

}  // namespace

Descent descend(ProjectedModel& model, const VectorXd& nonlinear, const DescentOptions& options) {
  return DampedDescent(model, options).run(nonlinear);
}

}  // namespace silvafit::fit
