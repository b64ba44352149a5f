// SPDX-License-Identifier: MIT
#include "optimization/quasi_newton.hpp"

#include <ceres/gradient_problem.h>
#include <ceres/gradient_problem_solver.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "silvafit/base/constants.hpp"

#ifdef __ELF__
// Of glog, which is not linked everywhere; its own headers do not say that it may be missing.
namespace fLI {
[[gnu::weak]] extern int FLAGS_minloglevel;
}
namespace google {
[[gnu::weak]] bool IsGoogleLoggingInitialized();  // NOLINT(readability-redundant-declaration)
}
#endif

namespace silvafit::fit {
namespace {

/// Ceres tells glog of steps that fail even where its own options ask for silence. A program that
/// uses glog itself keeps its level; Ceres may also be built with a logging of its own.
void silence_warnings() {
#ifdef __ELF__
  [[maybe_unused]] static const bool is_done = [] {  // once, although there may be many threads
    constexpr int kFatal = 3;
    const bool is_ours =
        &fLI::FLAGS_minloglevel != nullptr && !google::IsGoogleLoggingInitialized();
    if (is_ours) fLI::FLAGS_minloglevel = kFatal;
    return true;
  }();
#endif
}

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

/// Two sides that differ by less have a mean that is right to the square of it.
constexpr double kSidesAgree = 1e-4;

VectorXd unknown(Index size) { return VectorXd::Constant(size, kNaN); }

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

/// A column of the Hessian from differences of the gradient to both sides.
struct HessianColumn {
  VectorXd mean{};      ///< of the two sides; the other one at the end of the domain
  VectorXd half_gap{};  ///< half of their difference: step times third derivative, over 2
};

HessianColumn column_at(const SmoothFunction& function,
                        const VectorXd& x,
                        const VectorXd& gradient,
                        Index variable,
                        double step) {
  const std::optional<VectorXd> above = gradient_beside(function, x, variable, step);
  const std::optional<VectorXd> below = gradient_beside(function, x, variable, -step);
  HessianColumn column{unknown(x.size()), VectorXd::Zero(x.size())};
  if (above && below) {
    column.mean = (*above - *below) / (2.0 * step);
    column.half_gap = (*above - 2.0 * gradient + *below) / (2.0 * step);
  } else if (above || below) {
    column.mean = above ? (*above - gradient) / step : (gradient - *below) / step;
  }
  return column;
}

/// The largest gap between the sides, relative to the curvatures of both variables.
double relative_gap(const MatrixXd& hessian, Index variable, const VectorXd& half_gap) {
  const VectorXd curvature = hessian.diagonal().cwiseAbs();
  constexpr double kSmallestShare = 1e-6;
  const double floor = std::max(kSmallestShare * curvature.maxCoeff(), 1e-300);
  const VectorXd size = curvature.cwiseMax(floor).cwiseSqrt();
  return half_gap.cwiseQuotient(size).cwiseAbs().maxCoeff() / size[variable];
}

/// Shortens the step of a column until its two sides agree, as long as this brings them closer.
void refine_column(const SmoothFunction& function,
                   const VectorXd& x,
                   const VectorXd& gradient,
                   Index variable,
                   const VectorXd& half_gap,
                   MatrixXd& hessian) {
  constexpr int kRefinements = 4;
  double step = step_of(x[variable]);
  double gap = relative_gap(hessian, variable, half_gap);
  for (int k = 0; k < kRefinements && gap > kSidesAgree; ++k) {
    const double share = std::clamp(0.5 * kSidesAgree / gap, 1e-3, 0.1);
    step *= share;
    const HessianColumn column = column_at(function, x, gradient, variable, step);
    MatrixXd refined = hessian;
    refined.col(variable) = column.mean;
    const double next = relative_gap(refined, variable, column.half_gap);
    // The gap falls with the step, unless it is due to rounding errors or a kink.
    if (!(next < 2.0 * share * gap)) return;
    hessian = std::move(refined);
    gap = next;
  }
}

/// The Hessian from central differences, not symmetrized.
/// \param half_gaps  (n x n) out: half the differences of the sides
MatrixXd central_hessian(const SmoothFunction& function,
                         const VectorXd& x,
                         const VectorXd& gradient,
                         MatrixXd& half_gaps) {
  MatrixXd hessian(x.size(), x.size());
  half_gaps.resize(x.size(), x.size());
  for (Index i = 0; i < x.size(); ++i) {
    HessianColumn column = column_at(function, x, gradient, i, step_of(x[i]));
    hessian.col(i) = column.mean;
    half_gaps.col(i) = column.half_gap;
  }
  return hessian;
}

/// A point where the function was evaluated.
struct Evaluated {
  VectorXd z{};  ///< its whitened coordinates
  VectorXd x{};
  double value = kInfinity;
  VectorXd gradient{};
};

/// What Ceres sees: the function in the coordinates z of x = center + L^-T z, in which the first
/// Hessian L L' is the identity that BFGS starts from.
class WhitenedFunction final : public ceres::FirstOrderFunction {
 public:
  WhitenedFunction(const SmoothFunction& function,
                   Evaluated first,
                   const MatrixXd& hessian,
                   double longest_step,
                   int& evaluations)
      : function_(function),
        center_(first.x),
        cholesky_(hessian),
        longest_step_(longest_step),
        evaluations_(evaluations),
        lowest_(first),
        tried_{std::move(first)} {}

  int NumParameters() const override { return static_cast<int>(center_.size()); }

  bool Evaluate(const double* parameters, double* value, double* gradient) const override {
    const Evaluated* here = at(Eigen::Map<const VectorXd>(parameters, center_.size()));
    if (here == nullptr || !std::isfinite(here->value)) return false;
    *value = here->value;
    if (gradient != nullptr) {
      Eigen::Map<VectorXd>(gradient, center_.size()) = cholesky_.matrixL().solve(here->gradient);
    }
    return true;
  }

  const Evaluated& lowest() const { return lowest_; }
  /// Where the solver is.
  const Evaluated& current() const { return tried_.front(); }
  void move(const VectorXd& z) {
    const Evaluated* next = at(z);
    if (next != nullptr) tried_ = {Evaluated(*next)};
  }

 private:
  /// Evaluates once. The solver has no longest step: points beyond it are refused, not evaluated.
  const Evaluated* at(const VectorXd& z) const {
    const auto known = std::find_if(
        tried_.begin(), tried_.end(), [&](const Evaluated& one) { return one.z == z; });
    if (known != tried_.end()) return &*known;
    Evaluated next{.z = z, .x = center_ + cholesky_.matrixU().solve(z)};
    const double step = (next.x - current().x).lpNorm<Eigen::Infinity>();
    if (!(step <= longest_step_)) return nullptr;
    ++evaluations_;
    next.gradient.setZero(center_.size());
    next.value = function_(next.x, &next.gradient);
    if (!next.gradient.allFinite()) next.value = kInfinity;
    if (next.value < lowest_.value) lowest_ = next;
    tried_.push_back(std::move(next));
    return &tried_.back();
  }

  const SmoothFunction& function_;
  VectorXd center_;
  Eigen::LLT<MatrixXd> cholesky_;
  double longest_step_;
  int& evaluations_;
  mutable Evaluated lowest_;
  mutable std::vector<Evaluated> tried_;  ///< since the last step; first where the solver is
};

/// One minimization: current point, gradient and Hessian.
class Minimization final : private ceres::IterationCallback {
 public:
  Minimization(const SmoothFunction& function,
               const VectorXd& start,
               const MatrixXd& hessian,
               const QuasiNewtonOptions& options)
      : function_(function), options_(options) {
    result_.x = start;
    gradient_.setZero(start.size());
    result_.value = evaluate(start, gradient_);
    if (hessian.size() > 0) {
      result_.hessian = made_positive(hessian);
    } else {
      renew_hessian();
    }
    is_fresh_ = hessian.size() == 0;
  }

  QuasiNewtonResult run() {
    if (result_.x.size() == 0 || !std::isfinite(result_.value)) return result_;
    result_.decrement = decrement(gradient_);
    while (result_.decrement > options_.decrement && steps_ < options_.maximum_steps) {
      const double before = result_.decrement;
      const bool was_fresh = is_fresh_;
      solve();
      if (result_.is_blocked) break;
      polish();
      if (result_.decrement <= std::max(options_.decrement, options_.rounded_decrement)) break;
      // With an accurate Hessian, rounding is what prevents more.
      if (was_fresh && !(result_.decrement < 0.5 * before)) break;
      renew_hessian();
      is_fresh_ = true;
      result_.decrement = decrement(gradient_);
    }
    return result_;
  }

 private:
  double evaluate(const VectorXd& x, VectorXd& gradient) {
    ++result_.evaluations;
    return function_(x, &gradient);
  }

  /// By rounding the Hessian may be indefinite; its direction is then useless.
  double decrement(const VectorXd& gradient) const {
    const double found = gradient.dot(result_.hessian.ldlt().solve(gradient));
    if (!(found >= 0.0)) return kInfinity;
    return found;
  }

  void renew_hessian() {
    result_.evaluations += static_cast<int>(result_.x.size()) * (options_.one_sided ? 1 : 2);
    MatrixXd half_gaps;
    const MatrixXd found = options_.one_sided
                               ? one_sided_hessian(function_, result_.x, gradient_)
                               : central_hessian(function_, result_.x, gradient_, half_gaps);
    result_.hessian = made_positive(0.5 * (found + found.transpose()));
  }

  /// From the current point with the current Hessian to where Ceres ends.
  void solve() {
    const Index size = result_.x.size();
    z_.setZero(size);
    whitened_ = new WhitenedFunction(function_,
                                     {z_, result_.x, result_.value, gradient_},
                                     result_.hessian,
                                     options_.longest_step,
                                     result_.evaluations);
    const ceres::GradientProblem problem(whitened_);  // owns it
    ceres::GradientProblemSolver::Options options;
    options.line_search_direction_type = ceres::BFGS;
    options.max_num_iterations = options_.maximum_steps - steps_;
    options.function_tolerance = 0.0;
    options.gradient_tolerance = 0.0;
    options.parameter_tolerance = 0.0;
    options.logging_type = ceres::SILENT;
    options.update_state_every_iteration = true;
    options.callbacks.push_back(this);
    ceres::GradientProblemSolver::Summary summary;
    silence_warnings();
    ceres::Solve(options, problem, z_.data(), &summary);
    ++steps_;  // also if no step was possible
    const Evaluated& lowest = whitened_->lowest();
    if (lowest.value < result_.value) is_fresh_ = false;
    result_.x = lowest.x;
    result_.value = lowest.value;
    gradient_ = lowest.gradient;
    result_.decrement = decrement(gradient_);
  }

  /// After each step of the solver: keeps the Hessian, stops by the decrement.
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (summary.iteration == 0) return ceres::SOLVER_CONTINUE;
    ++steps_;
    const VectorXd x = whitened_->current().x;
    const VectorXd gradient = whitened_->current().gradient;
    whitened_->move(z_);
    const Evaluated& here = whitened_->current();
    update_bfgs(result_.hessian, here.x - x, here.gradient - gradient);
    constexpr double kShort = 0.1;
    short_steps_ = summary.step_size < kShort ? short_steps_ + 1 : 0;
    result_.is_blocked = options_.most_short_steps > 0 && short_steps_ >= options_.most_short_steps;
    const double found = decrement(here.gradient);
    const bool is_end = found <= options_.decrement || is_rounded(found) || result_.is_blocked;
    return is_end ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }

  bool is_rounded(double found) {
    constexpr int kSteps = 3;
    if (found < 0.5 * least_decrement_) {
      least_decrement_ = found;
      vain_steps_ = 0;
      return false;
    }
    return ++vain_steps_ >= kSteps && found <= options_.rounded_decrement;
  }

  /// Newton steps where rounding hides the decrease of the value, so that the solver's line search
  /// refuses them: the gradient shows whether they come closer.
  void polish() {
    constexpr double kNear = 1e-4;  // one hundredth of a standard error
    while (result_.decrement > options_.decrement && result_.decrement <= kNear) {
      const VectorXd x = result_.x - result_.hessian.ldlt().solve(gradient_);
      VectorXd gradient = VectorXd::Zero(x.size());
      const double value = evaluate(x, gradient);
      const double next = decrement(gradient);
      if (!(value <= result_.value + result_.decrement) || !(next < 0.5 * result_.decrement))
        return;
      result_.x = x;
      result_.value = value;
      result_.decrement = next;
      gradient_ = gradient;
    }
  }

  const SmoothFunction& function_;
  QuasiNewtonOptions options_;
  QuasiNewtonResult result_;
  VectorXd gradient_;
  VectorXd z_;  ///< where the solver is
  WhitenedFunction* whitened_ = nullptr;
  bool is_fresh_ = false;  ///< whether the Hessian belongs to the current point
  double least_decrement_ = kInfinity;
  int steps_ = 0;
  int vain_steps_ = 0;
  int short_steps_ = 0;  ///< consecutive
};

}  // namespace

MatrixXd hessian_from_gradients(const SmoothFunction& function,
                                const VectorXd& x,
                                const VectorXd& gradient) {
  MatrixXd half_gaps;
  MatrixXd hessian = central_hessian(function, x, gradient, half_gaps);
  for (Index i = 0; i < x.size(); ++i) {
    refine_column(function, x, gradient, i, half_gaps.col(i), hessian);
  }
  return 0.5 * (hessian + hessian.transpose());
}

MatrixXd hessian_over_errors(const SmoothFunction& function,
                             const VectorXd& x,
                             const VectorXd& gradient) {
  constexpr double kFirstStep = 0.1;
  constexpr double kShortestStep = 1e-4;
  constexpr int kRounds = 3;
  MatrixXd hessian(x.size(), x.size());
  for (Index i = 0; i < x.size(); ++i) {
    double step = kFirstStep;
    for (int round = 0; round < kRounds; ++round) {
      hessian.col(i) = column_at(function, x, gradient, i, step).mean;
      if (hessian(i, i) > 0.0)
        step = std::clamp(1.0 / std::sqrt(hessian(i, i)), kShortestStep, kFirstStep);
    }
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
