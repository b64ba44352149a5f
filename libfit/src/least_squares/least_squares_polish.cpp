// SPDX-License-Identifier: MIT
// All steps are computed in u = R beta, where J = QR: there J'J is the identity, so that units and
// correlations of the coefficients cause no rounding.
#include "least_squares/least_squares_polish.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "least_squares/jacobian_factors.hpp"
#include "least_squares/least_squares_curvature.hpp"
#include "optimization/kinked_minimum.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMaximumSteps = 20;
constexpr int kMaximumHalvings = 12;

class Refinement {
 public:
  Refinement(const NonlinearModel& model, const VectorXd& coefficients) : model_(model) {
    point_.coefficients = coefficients;
  }

  /// The evidence at the point, without a step.
  NewtonPoint stay() {
    if (!linearize()) return point_;
    newton_step();
    finish();
    return point_;
  }

  NewtonPoint run() {
    NewtonPoint best;
    for (; point_.iterations < kMaximumSteps; ++point_.iterations) {
      if (!linearize()) return point_;
      const VectorXd u = newton_step();
      // If rounding hides a gain in the sum of squares, the decrement still shows it.
      const bool is_better = point_.iterations == 0 || point_.decrement < best.decrement ||
                             point_.sum_of_squares < best.sum_of_squares - noise();
      if (!is_better) break;
      best = point_;
      if (point_.decrement <= 1e-3 * point_.rounding) break;
      if (!take(factors().to_coefficients(u))) break;
    }
    if (point_.coefficients != best.coefficients) {
      const int iterations = point_.iterations;
      point_ = best;
      point_.iterations = iterations;
      linearize();
    }
    finish();
    return point_;
  }

 private:
  const JacobianFactors& factors() const { return *factors_; }

  bool linearize() {
    model_.evaluate(point_.coefficients, point_.mean, &jacobian_, workspace_);
    residuals_ = model_.response() - point_.mean;
    point_.sum_of_squares = residuals_.squaredNorm();
    point_.finite = residuals_.allFinite() && jacobian_.allFinite();
    if (point_.finite) factors_.emplace(jacobian_, JacobianFactors::kRankTolerance, residuals_);
    return point_.finite;
  }

  double residual_variance() const {
    const Index freedom = std::max<Index>(model_.observations() - factors().rank(), 1);
    return point_.sum_of_squares / static_cast<double>(freedom);
  }

  /// Rounding error of the sum of squares for observations of this size.
  double noise() const {
    return 4.0 * kEpsilon * residuals_.norm() * (residuals_.norm() + model_.response().norm());
  }

  /// The step in u; fills in the evidence.
  VectorXd newton_step() {
    const VectorXd& gradient = factors().projected();
    const double variance = residual_variance();
    const double size = model_.response().squaredNorm() + point_.mean.squaredNorm();
    point_.rounding = std::pow(8.0 * kEpsilon, 2) * size / variance;
    const Eigen::LLT<MatrixXd> hessian(curvature());
    point_.positive_curvature = hessian.info() == Eigen::Success;
    VectorXd step = point_.positive_curvature ? VectorXd(hessian.solve(gradient)) : gradient;
    point_.decrement = variance > 0.0 ? gradient.dot(step) / variance : 0.0;
    return step;
  }

  /// Hessian of half the sum of squares in u: the identity minus the part of the residuals.
  MatrixXd curvature() const {
    const Index r = factors().rank();
    const MatrixXd directions = factors().to_coefficients(MatrixXd::Identity(r, r));
    const MatrixXd bend = residual_curvature(model_, point_.coefficients, residuals_);
    const MatrixXd hessian = MatrixXd::Identity(r, r) - directions.transpose() * bend * directions;
    if (!hessian.allFinite()) return MatrixXd::Identity(r, r);
    return hessian;
  }

  /// Makes the step, or a part of it that does not increase the sum of squares beyond rounding.
  bool take(const VectorXd& step) {
    VectorXd mean;
    double share = 1.0;
    for (int halving = 0; halving < kMaximumHalvings; ++halving, share *= 0.5) {
      const VectorXd candidate = point_.coefficients + share * step;
      model_.evaluate(candidate, mean, nullptr, workspace_);
      const double sum_of_squares = (model_.response() - mean).squaredNorm();
      if (sum_of_squares <= point_.sum_of_squares + noise()) {
        const bool moved = candidate != point_.coefficients;
        point_.coefficients = candidate;
        return moved;
      }
    }
    return false;
  }

  void finish() {
    point_.rank = static_cast<int>(factors().rank());
    point_.confounded = factors().confounded();
    const MatrixXd root =
        factors().to_coefficients(MatrixXd::Identity(factors().rank(), factors().rank()));
    point_.unscaled_covariance = root * root.transpose();
    for (const Index i : point_.confounded) {
      point_.unscaled_covariance.row(i).setConstant(kNaN);
      point_.unscaled_covariance.col(i).setConstant(kNaN);
    }
  }

  const NonlinearModel& model_;
  NonlinearModel::Workspace workspace_;
  NewtonPoint point_;
  MatrixXd jacobian_;
  VectorXd residuals_;
  std::optional<JacobianFactors> factors_;
};

}  // namespace

NewtonPoint refine(const NonlinearModel& model, const VectorXd& coefficients) {
  return Refinement(model, coefficients).run();
}

NewtonPoint evidence_at(const NonlinearModel& model, const VectorXd& coefficients) {
  return Refinement(model, coefficients).stay();
}

std::optional<NewtonPoint> minimum_at_kinks(const NonlinearModel& model, const NewtonPoint& stuck) {
  const Index p = stuck.coefficients.size();
  const Index freedom = model.observations() - p;
  if (!stuck.finite || stuck.rank < p || freedom <= 0) return std::nullopt;
  const double variance = stuck.sum_of_squares / static_cast<double>(freedom);
  const Eigen::LLT<MatrixXd> scale(stuck.unscaled_covariance * variance);
  if (scale.info() != Eigen::Success) return std::nullopt;
  // Coordinates in which the standard errors are one and not correlated.
  const MatrixXd frame = scale.matrixL();
  NonlinearModel::Workspace workspace;
  const auto coefficients = [&](const VectorXd& x) {
    return VectorXd(stuck.coefficients + frame * x);
  };
  const SmoothFunction function = [&](const VectorXd& x, VectorXd* gradient) {
    VectorXd mean;
    MatrixXd jacobian;
    model.evaluate(coefficients(x), mean, &jacobian, workspace);
    const VectorXd residuals = model.response() - mean;
    if (gradient != nullptr) {
      *gradient = -frame.transpose() * (jacobian.transpose() * residuals) / variance;
    }
    return residuals.squaredNorm() / (2.0 * variance);
  };
  const HessianFunction hessian = [&](const VectorXd& x) {
    return MatrixXd(frame.transpose() * least_squares_hessian(model, coefficients(x)) * frame /
                    variance);
  };
  const auto found = minimum_at_kinks(function, VectorXd::Zero(p), hessian);
  if (!found) return std::nullopt;
  NewtonPoint result = evidence_at(model, coefficients(found->x));
  result.decrement = found->decrement;
  result.positive_curvature = true;
  result.kinked = kinked_coefficients(frame, found->normals);
  return result;
}

bool is_converged(const NewtonPoint& point) {
  constexpr double kSquaredStandardErrors = 1e-10;
  return point.finite && point.positive_curvature &&
         point.decrement <= std::max(kSquaredStandardErrors, point.rounding);
}

Index numerical_rank(const MatrixXd& jacobian) { return JacobianFactors(jacobian).rank(); }

}  // namespace silvafit::fit
