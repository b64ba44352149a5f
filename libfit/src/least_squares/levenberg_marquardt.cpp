// SPDX-License-Identifier: MIT
#include "least_squares/levenberg_marquardt.hpp"

#include <ceres/ceres.h>

#include <limits>
#include <memory>

#include "silvafit/base/stop.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// All residuals as one cost function of the nonlinear coefficients. Stores the lowest point, which
/// Ceres loses if a later evaluation fails.
class ResidualCost final : public ceres::CostFunction {
 public:
  ResidualCost(ProjectedModel& model, Descent& best) : model_(model), best_(best) {
    set_num_residuals(static_cast<int>(model.model().observations()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(model.size()));
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const VectorXd point = Eigen::Map<const VectorXd>(parameters[0], model_.size());
    // Ceres asks for the residuals of a step and then, if they are lower, for the derivative at the
    // same point. If there is none, the step must fail at once: later it would end the descent.
    if (point_.size() == 0 || point != point_) visit(point);
    if (!point_is_good_) return false;
    Eigen::Map<VectorXd>(residuals, model_.residuals().size()) = model_.residuals();
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    if (model_.size() == 1) {
      Eigen::Map<VectorXd>(jacobians[0], jacobian_.rows()) = jacobian_.col(0);
    } else {
      Eigen::Map<RowMajor>(jacobians[0], jacobian_.rows(), jacobian_.cols()) = jacobian_;
    }
    return true;
  }

  /// Evaluates at a point; false where the mean or its derivative is not finite.
  bool visit(const VectorXd& point) const {
    point_ = point;
    point_is_good_ = evaluate(point);
    if (!point_is_good_) return false;
    const double sum_of_squares = model_.residuals().squaredNorm();
    if (sum_of_squares < best_.sum_of_squares) {
      best_.sum_of_squares = sum_of_squares;
      best_.coefficients = model_.coefficients();
    }
    return true;
  }

 private:
  bool evaluate(const VectorXd& point) const {
    try {
      return model_.evaluate(point) && model_.evaluate_jacobian(jacobian_);
    } catch (const Stopped&) {
      // Ceres does not support exceptions; the descent ends soon if each step fails.
      return false;
    }
  }

  mutable VectorXd point_;
  mutable bool point_is_good_ = false;
  ProjectedModel& model_;
  Descent& best_;
  mutable Eigen::MatrixXd jacobian_;
};

ceres::Solver::Options solver_options(const DescentOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = options.maximum_iterations;
  solver.function_tolerance = options.tolerance;
  solver.parameter_tolerance = 1e-15;
  solver.gradient_tolerance = std::numeric_limits<double>::min();
  solver.max_num_consecutive_invalid_steps = 40;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

Descent descend(ProjectedModel& model, const VectorXd& nonlinear, const DescentOptions& options) {
  Descent best{.sum_of_squares = std::numeric_limits<double>::infinity()};
  if (!model.evaluate(nonlinear)) return best;
  best.coefficients = model.coefficients();
  best.sum_of_squares = model.residuals().squaredNorm();
  if (model.size() == 0) return best;
  auto cost = std::make_unique<ResidualCost>(model, best);
  if (!cost->visit(nonlinear)) return best;

  VectorXd point = nonlinear;
  ceres::Problem problem;
  problem.AddResidualBlock(cost.release(), nullptr, point.data());
  if (options.held >= 0) {
    problem.SetManifold(point.data(),
                        new ceres::SubsetManifold(static_cast<int>(point.size()), {options.held}));
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options), &problem, &summary);
  model.model().check_stop();
  best.iterations = static_cast<int>(summary.iterations.size());
  return best;
}

}  // namespace silvafit::fit
