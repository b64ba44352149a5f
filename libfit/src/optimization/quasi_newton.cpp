// SPDX-License-Identifier: MIT
#include "optimization/quasi_newton.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The nearest matrix with the same eigenvectors and eigenvalues |lambda| >= a small share of the
/// largest.
MatrixXd made_positive(const MatrixXd& hessian) {
  if (hessian.rows() == 0) return hessian;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(hessian);
  if (solver.info() != Eigen::Success || !solver.eigenvalues().allFinite()) {
    return MatrixXd::Identity(hessian.rows(), hessian.cols());
  }
  constexpr double kSmallestShare = 1e-10;
  const VectorXd magnitudes = solver.eigenvalues().cwiseAbs();
  const double floor = std::max(kSmallestShare * magnitudes.maxCoeff(), 1e-12);
  return solver.eigenvectors() * magnitudes.cwiseMax(floor).asDiagonal() *
         solver.eigenvectors().transpose();
}

void update_bfgs(MatrixXd& hessian, const VectorXd& step, const VectorXd& change) {
  const double curvature = step.dot(change);
  const VectorXd product = hessian * step;
  const double old_curvature = step.dot(product);
  // Too little curvature along the step would make the matrix less accurate.
  if (!(curvature > 1e-10 * old_curvature) || !(old_curvature > 0.0)) return;
  hessian +=
      change * change.transpose() / curvature - product * product.transpose() / old_curvature;
}

/// The step of a variable whose unit is of order one. It does not grow with a variable far from
/// zero, such as a constant near 1e6 with residuals of order one: the curvature does not change.
double step_of(double x) { return 1e-5 * std::clamp(std::abs(x), 1.0, 10.0); }

VectorXd unknown(Index size) {
  return VectorXd::Constant(size, std::numeric_limits<double>::quiet_NaN());
}

/// The gradient a step away in one variable; no value outside of the domain of the function.
std::optional<VectorXd> gradient_beside(const SmoothFunction& function,
                                        const VectorXd& x,
                                        Index variable,
                                        double step) {
  VectorXd moved = x;
  moved[variable] += step;
  VectorXd gradient(x.size());
  if (!std::isfinite(function(moved, &gradient))) return std::nullopt;
  return gradient;
}

/// One minimization: current point, gradient and Hessian.
class Minimization {
 public:
  Minimization(const SmoothFunction& function,
               const VectorXd& start,
               const MatrixXd& hessian,
               const QuasiNewtonOptions& options)
      : function_(function), options_(options) {
    result_.x = start;
    gradient_.setZero(start.size());
    result_.value = evaluate(start, &gradient_);
    if (hessian.size() > 0) {
      result_.hessian = made_positive(hessian);
    } else {
      result_.hessian = made_positive(options_.one_sided ? rough_hessian() : fresh_hessian());
    }
    is_fresh_ = hessian.size() == 0;
  }

  QuasiNewtonResult run() {
    if (result_.x.size() == 0 || !std::isfinite(result_.value)) return result_;
    for (int step = 0; step < options_.maximum_steps; ++step) {
      const VectorXd direction = -result_.hessian.ldlt().solve(gradient_);
      result_.decrement = -gradient_.dot(direction);
      // By rounding the Hessian may be indefinite; its direction is then useless.
      if (!(result_.decrement >= 0.0)) result_.decrement = std::numeric_limits<double>::infinity();
      if (result_.decrement <= options_.decrement || is_rounded()) break;
      result_.is_blocked =
          options_.most_short_steps > 0 && short_steps_ >= options_.most_short_steps;
      if (result_.is_blocked) break;
      if (std::isfinite(result_.decrement) && advance(direction)) continue;
      if (result_.decrement <= options_.rounded_decrement) break;
      // No descent: the Hessian is inaccurate, or the value is exact except for rounding.
      if (is_fresh_) break;
      result_.hessian = made_positive(fresh_hessian());
      is_fresh_ = true;
    }
    return result_;
  }

 private:
  double evaluate(const VectorXd& x, VectorXd* gradient) {
    ++result_.evaluations;
    return function_(x, gradient);
  }

  bool is_rounded() {
    constexpr int kSteps = 3;
    if (result_.decrement < 0.5 * least_decrement_) {
      least_decrement_ = result_.decrement;
      vain_steps_ = 0;
      return false;
    }
    return ++vain_steps_ >= kSteps && result_.decrement <= options_.rounded_decrement;
  }

  MatrixXd fresh_hessian() {
    result_.evaluations += 2 * static_cast<int>(result_.x.size());
    return hessian_from_gradients(function_, result_.x);
  }

  MatrixXd rough_hessian() {
    result_.evaluations += static_cast<int>(result_.x.size());
    const MatrixXd hessian = one_sided_hessian(function_, result_.x, gradient_);
    return 0.5 * (hessian + hessian.transpose());
  }

  bool advance(VectorXd direction) {
    const double longest = direction.cwiseAbs().maxCoeff();
    if (longest > options_.longest_step) direction *= options_.longest_step / longest;
    const double slope = gradient_.dot(direction);
    constexpr double kArmijo = 1e-4;
    constexpr int kHalvings = 40;
    // If the descent is near rounding errors, shorter steps are useless.
    constexpr int kRoundedHalvings = 4;
    const int halvings =
        result_.decrement <= options_.rounded_decrement ? kRoundedHalvings : kHalvings;
    // Near the optimum the descent predicted by the gradient is below the rounding of the value.
    const double rounding = 1e-14 * std::max(1.0, std::abs(result_.value));
    double length = 1.0;
    for (int halving = 0; halving < halvings; ++halving, length *= 0.5) {
      const VectorXd x = result_.x + length * direction;
      VectorXd gradient(x.size());
      const double value = evaluate(x, &gradient);
      if (!std::isfinite(value) || !gradient.allFinite()) continue;
      if (value > result_.value + kArmijo * length * slope + rounding) continue;
      if (value >= result_.value && gradient.norm() >= gradient_.norm()) continue;
      update_bfgs(result_.hessian, length * direction, gradient - gradient_);
      result_.x = x;
      result_.value = value;
      gradient_ = gradient;
      is_fresh_ = false;
      constexpr double kShort = 0.1;
      short_steps_ = length < kShort ? short_steps_ + 1 : 0;
      return true;
    }
    return false;
  }

  const SmoothFunction& function_;
  QuasiNewtonOptions options_;
  QuasiNewtonResult result_;
  VectorXd gradient_;
  bool is_fresh_ = false;
  double least_decrement_ = std::numeric_limits<double>::infinity();
  int vain_steps_ = 0;
  int short_steps_ = 0;  ///< consecutive
};

}  // namespace

MatrixXd hessian_from_gradients(const SmoothFunction& function, const VectorXd& x) {
  const Index size = x.size();
  MatrixXd hessian(size, size);
  for (Index i = 0; i < size; ++i) {
    const double step = step_of(x[i]);
    std::optional<VectorXd> above = gradient_beside(function, x, i, step);
    std::optional<VectorXd> below = gradient_beside(function, x, i, -step);
    const double distance = above && below ? 2.0 * step : step;
    if (above && !below) below = gradient_beside(function, x, i, 0.0);
    if (below && !above) above = gradient_beside(function, x, i, 0.0);
    hessian.col(i) = above && below ? VectorXd((*above - *below) / distance) : unknown(size);
  }
  return 0.5 * (hessian + hessian.transpose());
}

MatrixXd one_sided_hessian(const SmoothFunction& function,
                           const VectorXd& x,
                           const VectorXd& gradient) {
  const Index size = x.size();
  MatrixXd hessian(size, size);
  for (Index i = 0; i < size; ++i) {
    double step = step_of(x[i]);
    std::optional<VectorXd> beside = gradient_beside(function, x, i, step);
    if (!beside) {
      step = -step;
      beside = gradient_beside(function, x, i, step);
    }
    hessian.col(i) = beside ? VectorXd((*beside - gradient) / step) : unknown(size);
  }
  return hessian;
}

QuasiNewtonResult minimize(const SmoothFunction& function,
                           const VectorXd& start,
                           const MatrixXd& hessian,
                           const QuasiNewtonOptions& options) {
  return Minimization(function, start, hessian, options).run();
}

}  // namespace silvafit::fit
