// SPDX-License-Identifier: MIT
#include "lindstrom_bates.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "fixed_point.hpp"
#include "quasi_newton.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Index> random_columns(const NonlinearModel& model) {
  std::vector<Index> columns;
  if (!model.specification().random) return columns;
  for (const std::string& name : model.specification().random->coefficients) {
    columns.push_back(model.coefficient_index(name));
  }
  return columns;
}

/// Coefficient units in which the columns of the Jacobian have a root mean square of one.
VectorXd natural_scales(const NonlinearModel& model, const VectorXd& start) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(start, mean, &jacobian, workspace);
  VectorXd scales(start.size());
  for (Index j = 0; j < start.size(); ++j) {
    const double size =
        std::sqrt(jacobian.col(j).squaredNorm() / static_cast<double>(model.observations()));
    scales[j] = std::isfinite(size) && size > 0.0 ? 1.0 / size : 1.0;
  }
  return scales;
}

VectorXd chosen(const VectorXd& values, const std::vector<Index>& which) {
  VectorXd result(static_cast<Index>(which.size()));
  for (std::size_t k = 0; k < which.size(); ++k) result[static_cast<Index>(k)] = values[which[k]];
  return result;
}

/// The method has no fixed point for some data with small groups: its two steps then drive each
/// other on for ever.
class Stagnation {
 public:
  /// True when the last alternations have not halved the best decrement.
  bool after(double decrement) {
    if (decrement < 0.5 * best_) {
      best_ = decrement;
      waited_ = 0;
    }
    return ++waited_ > kPatience;
  }

 private:
  static constexpr int kPatience = 15;
  double best_ = std::numeric_limits<double>::infinity();
  int waited_ = 0;
};

// The factor 0.375 gives nlme's own start: random effects that explain most of the spread they can.
constexpr double kStartDivisor = 0.375;
// Directions of L that are smaller by this factor hold no random effects that count.
constexpr double kSmallestPivot = 1e-6;
// Moves of the variance components that have to be shorter than this lead nowhere.
constexpr double kShortestMove = 1e-2;
// Coordinates are chosen anew when a column of the Jacobian has become this much larger or smaller.
constexpr double kUnsuitable = 4.0;
// Enough to settle once the linearisation has; before that, more would be wasted.
constexpr int kThetaSteps = 30;
// One alternation has converged when it moves theta by less than 1e-6 standard errors.
constexpr double kConvergedDecrement = 1e-12;

}  // namespace

LindstromBates::LindstromBates(const NonlinearModel& model, const VectorXd& start)
    : model_(model),
      random_(random_columns(model)),
      start_(start),
      natural_scale_(natural_scales(model, start)),
      scale_(natural_scale_),
      factor_(model.specification().random.value_or(RandomEffects{}), chosen(scale_, random_)),
      variance_(model.specification().variance, VarianceData::of(model)) {}

VectorXd LindstromBates::factor_parameters(const VectorXd& theta) const {
  return theta.head(factor_.parameter_count());
}

VectorXd LindstromBates::variance_parameters(const VectorXd& theta) const {
  return theta.tail(variance_.parameter_count());
}

LindstromBatesState LindstromBates::start(double spread) {
  adopt_scale(natural_scale_);
  const auto q = static_cast<Index>(random_.size());
  LindstromBatesState state{
      .scale = natural_scale_,
      .beta = start_.cwiseQuotient(natural_scale_),
      .spherical = MatrixXd::Zero(q, model_.group_count()),
      .theta = VectorXd(factor_.parameter_count() + variance_.parameter_count())};
  // In scaled coordinates the mean square of each column of Z is one at the start.
  const double typical_rows =
      static_cast<double>(model_.observations()) / static_cast<double>(model_.group_count());
  const double deviation = spread / (kStartDivisor * std::sqrt(typical_rows));
  state.theta << factor_.from_diagonal(VectorXd::Constant(q, deviation)),
      hold_variance_ ? variance_.constant() : variance_.start();
  return state;
}

LindstromBatesState LindstromBates::with_theta(const LindstromBatesState& state,
                                               const VectorXd& theta) const {
  LindstromBatesState moved = state;
  moved.theta = theta;
  if (random_.empty()) return moved;
  // The random effects b = L v stay as they are, as far as the new L can hold them.
  const MatrixXd effects = factor_.factor(factor_parameters(state.theta)) * state.spherical;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(kSmallestPivot);
  solver.compute(factor_.factor(factor_parameters(theta)));
  moved.spherical = solver.solve(effects);
  return moved;
}

LindstromBatesState LindstromBates::first_order_start() {
  LindstromBatesState state = start(1.0);
  Linearisation at;
  if (!linearise(state, at)) return state;
  const SmoothFunction objective = [&](const VectorXd& theta, VectorXd* gradient) {
    return profile_at(at, theta, gradient);
  };
  const QuasiNewtonResult best =
      minimise(objective, state.theta, {}, {.maximum_steps = kThetaSteps});
  if (best.x.allFinite()) state.theta = best.x;
  return state;
}

void LindstromBates::adopt_scale(const VectorXd& scale) {
  scale_ = scale;
  factor_ = RelativeFactor(model_.specification().random.value_or(RandomEffects{}),
                           chosen(scale_, random_));
}

bool LindstromBates::rescale(LindstromBatesState& state, Linearisation& at) {
  const auto n = static_cast<double>(model_.observations());
  VectorXd size = (at.model.design.colwise().norm() / std::sqrt(n)).transpose();
  for (double& value : size) {
    if (!std::isfinite(value) || value == 0.0) value = 1.0;
  }
  if (size.maxCoeff() < kUnsuitable && size.minCoeff() > 1.0 / kUnsuitable) return false;
  const MatrixXd factor =
      chosen(size, random_).asDiagonal() * factor_.factor(factor_parameters(state.theta));
  state.scale = state.scale.cwiseQuotient(size);
  state.beta = state.beta.cwiseProduct(size);
  at.model.design = at.model.design * size.cwiseInverse().asDiagonal();
  adopt_scale(state.scale);
  state.theta.head(factor_.parameter_count()) = factor_.from_factor(factor);
  return true;
}

bool LindstromBates::linearise(const LindstromBatesState& state, Linearisation& at) {
  const MatrixXd effects = factor_.factor(factor_parameters(state.theta)) * state.spherical;
  MatrixXd coefficients = state.beta.replicate(1, model_.group_count());
  for (std::size_t k = 0; k < random_.size(); ++k) {
    coefficients.row(random_[k]) += effects.row(static_cast<Index>(k));
  }
  coefficients = scale_.asDiagonal() * coefficients;
  model_.evaluate(coefficients, at.mean, &at.model.design, workspace_);
  at.model.design = at.model.design * scale_.asDiagonal();
  at.residual = model_.response() - at.mean;
  at.model.working = at.residual;
  at.model.random = random_;
  at.model.group_begin.resize(static_cast<std::size_t>(model_.group_count()) + 1);
  for (Index j = 0; j <= model_.group_count(); ++j) at.model.group_begin[j] = model_.group_begin(j);
  for (Index j = 0; j < model_.group_count(); ++j) {
    const Index begin = model_.group_begin(j);
    const Index size = model_.group_begin(j + 1) - begin;
    for (std::size_t k = 0; k < random_.size(); ++k) {
      at.model.working.segment(begin, size) +=
          effects(static_cast<Index>(k), j) * at.model.design.col(random_[k]).segment(begin, size);
    }
  }
  return at.mean.allFinite() && at.model.design.allFinite();
}

LinearMixedProfile LindstromBates::profile_of(const Linearisation& at,
                                              const VectorXd& theta) const {
  const ResidualScale scale = variance_.scale(at.mean, variance_parameters(theta), false);
  const GroupMoments moments(at.model, scale.weight);
  return profile(at.model, moments, scale.sum_log, factor_.factor(factor_parameters(theta)));
}

double LindstromBates::profile_at(const Linearisation& at,
                                  const VectorXd& theta,
                                  VectorXd* gradient) const {
  const MatrixXd factor = factor_.factor(factor_parameters(theta));
  const ResidualScale scale =
      variance_.scale(at.mean, variance_parameters(theta), gradient != nullptr);
  const GroupMoments moments(at.model, scale.weight);
  const LinearMixedProfile value = profile(at.model, moments, scale.sum_log, factor);
  if (!value.is_valid) return std::numeric_limits<double>::infinity();
  if (gradient != nullptr) {
    gradient->resize(theta.size());
    gradient->head(factor_.parameter_count()) = factor_.gradient(value.by_factor);
    if (hold_variance_) {
      gradient->tail(variance_.parameter_count()).setZero();
    } else if (variance_.parameter_count() > 0) {
      gradient->tail(variance_.parameter_count()) =
          variance_gradient(at.model, moments, scale, factor, value);
    }
  }
  return value.minus_log_likelihood;
}

VectorXd LindstromBates::penalised_squares(const Linearisation& at,
                                           const MatrixXd& spherical,
                                           const ResidualScale& scale) const {
  const Eigen::ArrayXd squares = scale.weight * at.residual.array().square();
  VectorXd sums(model_.group_count());
  for (Index j = 0; j < model_.group_count(); ++j) {
    const Index begin = model_.group_begin(j);
    sums[j] = squares.segment(begin, model_.group_begin(j + 1) - begin).sum() +
              spherical.col(j).squaredNorm();
  }
  return sums;
}

double LindstromBates::take_step(LindstromBatesState& state,
                                 Linearisation& at,
                                 const ResidualScale& scale,
                                 const LinearMixedProfile& target) {
  const VectorXd current = penalised_squares(at, state.spherical, scale);
  const double total = current.sum();
  const MatrixXd change = target.spherical - state.spherical;
  // A few groups that run off must not hold back the others: at first their effects alone step
  // shorter. If that does not do, all step shorter together, which must descend in the end.
  constexpr int kGroupTrials = 6;
  constexpr int kTrials = 36;
  VectorXd group_length = VectorXd::Ones(model_.group_count());
  double length = 1.0;
  for (int attempt = 0; attempt < kTrials; ++attempt) {
    LindstromBatesState trial = state;
    trial.beta += length * target.coefficients;
    trial.spherical += length * change * group_length.asDiagonal();
    Linearisation point;
    const bool is_finite = linearise(trial, point);
    const VectorXd reached = penalised_squares(point, trial.spherical, scale);
    if (is_finite && reached.sum() <= total * (1.0 + 1e-13)) {
      state = std::move(trial);
      at = std::move(point);
      return length;
    }
    const auto runs_off = [&](Index j) { return !(reached[j] <= current[j] + 0.1 * total); };
    Index shortened = 0;
    for (Index j = 0; j < reached.size(); ++j) {
      if (!runs_off(j)) continue;
      group_length[j] *= 0.25;
      ++shortened;
    }
    if (attempt < kGroupTrials && shortened > 0) continue;
    group_length.setOnes();
    length *= 0.5;
  }
  return 0.0;
}

bool LindstromBates::penalised_least_squares(LindstromBatesState& state, Linearisation& at) {
  if (!linearise(state, at)) return false;
  const MatrixXd factor = factor_.factor(factor_parameters(state.theta));
  constexpr int kSteps = 100;
  // Many short steps in a row lead along a wall of the mean function, not to a solution.
  constexpr double kShort = 0.1;
  int short_steps = 0;
  double last_decrement = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kSteps; ++step) {
    const ResidualScale scale = variance_.scale(at.mean, variance_parameters(state.theta), false);
    const GroupMoments moments(at.model, scale.weight);
    const LinearMixedProfile target = profile(at.model, moments, scale.sum_log, factor);
    if (!target.is_valid) return false;
    const double current =
        (scale.weight * at.residual.array().square()).sum() + state.spherical.squaredNorm();
    const auto n = static_cast<double>(model_.observations());
    const double decrement = (current - target.sum_of_squares) / (target.sum_of_squares / n);
    // Rounding in the two sums is about n times the last digit.
    constexpr double kEnough = 1e-12;
    if (decrement <= kEnough || (decrement < 1e-7 && decrement >= 0.5 * last_decrement)) {
      return true;
    }
    last_decrement = decrement;
    const double length = take_step(state, at, scale, target);
    if (length == 0.0) return decrement < 1e-6;
    short_steps = length < kShort ? short_steps + 1 : 0;
    if (short_steps > short_steps_) return false;
  }
  return true;
}

void LindstromBates::hold_variance(bool hold) { hold_variance_ = hold; }

LindstromBatesState LindstromBates::with_free_variance(const LindstromBatesState& held) const {
  LindstromBatesState state = held;
  state.theta.tail(variance_.parameter_count()) = variance_.start();
  return state;
}

LindstromBatesOutcome LindstromBates::run(LindstromBatesState state, int maximum_iterations) {
  adopt_scale(state.scale);
  LindstromBatesOutcome outcome;
  AndersonMixing mixing(4);
  MatrixXd hessian;
  Linearisation at;
  LindstromBatesState last = state;  // where the two steps have last succeeded
  double length = 1.0;
  Stagnation stagnation;
  for (int iteration = 1; iteration <= maximum_iterations; ++iteration) {
    LindstromBatesState trial = state;
    if (!penalised_least_squares(trial, at)) {
      // Too far for the mean function: less far from where the last round stood.
      length *= 0.5;
      if (!outcome.is_valid || length < kShortestMove) break;
      mixing.restart();
      state = with_theta(last, last.theta + length * (state.theta - last.theta));
      continue;
    }
    length = 1.0;
    state = std::move(trial);
    if (rescale(state, at)) {
      mixing.restart();
      hessian.resize(0, 0);
    }
    const SmoothFunction objective = [&](const VectorXd& theta, VectorXd* gradient) {
      return profile_at(at, theta, gradient);
    };
    const double here = profile_at(at, state.theta, nullptr);
    const QuasiNewtonResult best =
        minimise(objective, state.theta, hessian, {.maximum_steps = kThetaSteps});
    if (!std::isfinite(here) || !best.x.allFinite()) break;
    hessian = best.hessian;
    const VectorXd change = best.x - state.theta;
    outcome.state = state;
    outcome.log_likelihood = -here;
    outcome.iterations = iteration;
    outcome.is_valid = true;
    outcome.decrement = change.size() > 0 ? change.dot(hessian * change) : 0.0;
    outcome.converged = outcome.decrement <= kConvergedDecrement;
    if (outcome.converged || stagnation.after(outcome.decrement)) break;
    last = state;
    state = with_theta(state, mixing.next(state.theta, best.x));
  }
  return outcome;
}

bool LindstromBates::leave_edge(const LindstromBatesOutcome& outcome, LindstromBatesState& inside) {
  if (random_.empty() || !outcome.is_valid) return false;
  inside = outcome.state;
  adopt_scale(inside.scale);
  Linearisation at;
  if (!linearise(inside, at)) return false;
  const LinearMixedProfile here = profile_of(at, inside.theta);
  if (!here.is_valid) return false;
  const MatrixXd factor = factor_.factor(factor_parameters(inside.theta));
  const MatrixXd covariance = factor * factor.transpose();
  // On the edge dF/dD must be positive semidefinite; a negative direction leads to a higher
  // likelihood.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(here.by_covariance);
  const VectorXd direction = solver.eigenvectors().col(0);
  if (solver.info() != Eigen::Success || solver.eigenvalues()[0] >= 0.0) return false;
  for (double size = 1.0; size > 1e-7; size *= 0.1) {
    const MatrixXd moved = covariance + size * direction * direction.transpose();
    VectorXd theta = inside.theta;
    theta.head(factor_.parameter_count()) = factor_.from_covariance(moved);
    const LinearMixedProfile there = profile_of(at, theta);
    if (there.is_valid && there.minus_log_likelihood < here.minus_log_likelihood - 1e-6) {
      inside.theta = theta;
      inside.spherical.setZero();
      return true;
    }
  }
  return false;
}

MixedEffectsFit LindstromBates::result(const LindstromBatesOutcome& outcome) {
  const LindstromBatesState& state = outcome.state;
  adopt_scale(state.scale);
  Linearisation at;
  linearise(state, at);
  const LinearMixedProfile value = profile_of(at, state.theta);
  const ResidualScale scale = variance_.scale(at.mean, variance_parameters(state.theta), false);
  const auto n = static_cast<double>(model_.observations());
  const double sigma2 = value.sum_of_squares / n;

  MixedEffectsFit fit;
  fit.estimate = state.beta.cwiseProduct(scale_);
  const Index p = fit.estimate.size();
  const MatrixXd inverse = value.information.ldlt().solve(MatrixXd::Identity(p, p));
  // nlme's factor for maximum-likelihood standard errors.
  const double adjusted = sigma2 * n / (n - static_cast<double>(p));
  fit.covariance = adjusted * scale_.asDiagonal() * inverse * scale_.asDiagonal();
  const VectorXd random_scale = chosen(scale_, random_);
  const MatrixXd factor =
      random_scale.asDiagonal() * factor_.factor(factor_parameters(state.theta));
  fit.random_covariance = sigma2 * factor * factor.transpose();
  fit.random_effects = factor * state.spherical;
  fit.sigma = std::sqrt(sigma2) * variance_.sigma_factor(variance_parameters(state.theta));
  fit.variance = variance_.estimate(variance_parameters(state.theta));
  fit.log_likelihood = outcome.log_likelihood;
  fit.parameter_count =
      static_cast<int>(p + factor_.parameter_count() + variance_.parameter_count()) + 1;
  fit.observations = model_.observations();
  fit.fitted_conditional = at.mean;
  model_.evaluate(fit.estimate, fit.fitted_population, nullptr, workspace_);
  fit.residual_sd = std::sqrt(sigma2) * scale.weight.rsqrt();
  fit.convergence.converged = outcome.converged;
  fit.convergence.gradient = outcome.decrement;
  fit.convergence.iterations = outcome.iterations;
  fit.floored_variances = variance_.floored(at.mean);
  return fit;
}

}  // namespace silvafit::fit
