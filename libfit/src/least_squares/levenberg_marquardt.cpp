// SPDX-License-Identifier: MIT
#include "least_squares/levenberg_marquardt.hpp"

#include <ceres/tiny_solver.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "least_squares/jacobian_factors.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

/// Steps shorter than this share of the coefficients are rounding.
constexpr double kShortestStep = 1e-15;

/// The function that Ceres sees. Its residuals are Q'r and its Jacobian the triangle R of the N
/// residuals r with Jacobian Q R: the same sums, without a second copy of N rows.
struct TriangularFunction {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };

  bool operator()(const double* at, double* residuals, double* jacobian) const {
    return evaluate(at, residuals, jacobian);
  }
  int NumResiduals() const { return parameters + 1; }
  int NumParameters() const { return parameters; }

  std::function<bool(const double*, double*, double*)> evaluate;
  int parameters = 0;
};

/// Steps are in coefficients that are multiplied by the lengths of the first Jacobian's columns.
class TinyDescent {
 public:
  TinyDescent(ProjectedModel& model, const DescentOptions& options)
      : model_(model), options_(options) {
    for (Index k = 0; k < model.size(); ++k) {
      if (k != options.held) free_.push_back(k);
    }
  }

  Descent run(const VectorXd& nonlinear) {
    if (!model_.evaluate(nonlinear)) return lowest_;
    point_ = nonlinear;
    keep();
    if (free_.empty() || !linearize()) return lowest_;
    solver_.options.max_num_iterations = options_.maximum_iterations + 1;
    solver_.options.gradient_tolerance = 0.0;
    solver_.options.cost_threshold = 0.0;
    solver_.options.parameter_tolerance = kShortestStep;
    VectorXd scaled = VectorXd(nonlinear(free_)).cwiseProduct(lengths_);
    const TriangularFunction function{
        [this](const double* parameters, double* residuals, double* jacobian) {
          if (jacobian == nullptr) {
            try_point(parameters, residuals);
          } else {
            show_lowest(residuals, jacobian);
          }
          return true;  // the solver ignores it
        },
        static_cast<int>(free_.size())};
    lowest_.iterations = solver_.Solve(function, &scaled).iterations;
    return lowest_;
  }

 private:
  /// The solver moves to each point that decreases the sum of squares, and asks for derivatives
  /// there: one without them counts as infinitely high.
  void try_point(const double* parameters, double* residuals) {
    const Index q = lengths_.size();
    VectorXd next = point_;
    next(free_) = Eigen::Map<const VectorXd>(parameters, q).cwiseQuotient(lengths_);
    double sum_of_squares = kInfinity;
    if (next.allFinite() && model_.evaluate(next)) {
      sum_of_squares = model_.residuals().squaredNorm();
      if (sum_of_squares < lowest_.sum_of_squares) {
        if (linearize()) {
          keep();
        } else {
          sum_of_squares = kInfinity;
        }
      }
    }
    Eigen::Map<VectorXd> shown(residuals, q + 1);
    shown.setZero();
    shown[q] = std::sqrt(sum_of_squares);
  }

  void show_lowest(double* residuals, double* jacobian) const {
    const Index q = lengths_.size();
    Eigen::Map<VectorXd> shown(residuals, q + 1);
    shown = triangle_.col(q);
    // So that the sum differs from those of tried points by what they gain, not by rounding.
    shown[q] = std::sqrt(std::max(0.0, lowest_.sum_of_squares - shown.head(q).squaredNorm()));
    Eigen::Map<MatrixXd>(jacobian, q + 1, q) = triangle_.leftCols(q);
  }

  /// The point of the last evaluation becomes the lowest.
  void keep() {
    lowest_.coefficients = model_.coefficients();
    lowest_.sum_of_squares = model_.residuals().squaredNorm();
    // The solver's test is absolute.
    solver_.options.function_tolerance = options_.tolerance * lowest_.sum_of_squares;
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
    MatrixXd triangle = triangle_of(jacobian_, lengths_, model_.residuals());
    if (!triangle.allFinite()) return false;
    triangle_ = std::move(triangle);
    return true;
  }

  ProjectedModel& model_;
  const DescentOptions& options_;
  ceres::TinySolver<TriangularFunction> solver_;
  std::vector<Index> free_;  ///< nonlinear coefficients that are not held
  VectorXd point_;           ///< (q) the first point, which holds the others
  VectorXd lengths_;         ///< of the columns of the first Jacobian
  MatrixXd jacobian_;
  MatrixXd triangle_;  ///< R and Q'r at the lowest point
  Descent lowest_{.sum_of_squares = kInfinity};
};

}  // namespace

Descent descend(ProjectedModel& model, const VectorXd& nonlinear, const DescentOptions& options) {
  return TinyDescent(model, options).run(nonlinear);
}

}  // namespace silvafit::fit
