// SPDX-License-Identifier: MIT
// Fits and alternations: the start at a fit or away from the boundary, and the fit of a result.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "lindstrom_bates/lindstrom_bates.hpp"
#include "model/kinked_range.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

/// A covariance further inside its range, along a direction in which the likelihood increases;
/// false if there is none.
bool rising_direction(const MatrixXd& by_covariance, VectorXd& direction) {
  if (by_covariance.rows() == 0) return false;
  // At a maximum on the boundary dF/dD is positive semidefinite.
  constexpr double kFlat = 1e-6;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(by_covariance);
  if (solver.info() != Eigen::Success || solver.eigenvalues()[0] >= -kFlat) return false;
  direction = solver.eigenvectors().col(0);
  return true;
}

/// NaN if the likelihood is not finite or the information is singular.
MatrixXd inverse_information(const LinearMixedProfile& at) {
  const Index p = at.information.rows();
  const Eigen::LDLT<MatrixXd> factor(at.information);
  if (!at.is_valid || factor.info() != Eigen::Success || !factor.isPositive()) {
    return MatrixXd::Constant(p, p, kNaN);
  }
  return factor.solve(MatrixXd::Identity(p, p));
}

}  // namespace

LindstromBatesState LindstromBates::start_at(const MixedEffectsFit& fit) {
  adopt_units(pooled_.scale, pooled_.mixing);
  const VectorXd parameters = variance_.inside_range(fit.variance);
  const double sigma = fit.sigma / variance_.sigma_factor(parameters);
  LindstromBatesState state{
      .scale = scale_, .mixing = mixing_, .beta = scaled_values(all_, fit.estimate)};
  state.theta.resize(random_parameter_count() + parameters.size());
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    const MatrixXd half = scaled_values(random_[t], fit.random[t].covariance);
    const MatrixXd relative = scaled_values(random_[t], half.transpose()) / (sigma * sigma);
    state.theta.segment(begin, factor.parameter_count()) = factor.from_covariance(relative);
  });
  state.theta.tail(parameters.size()) = parameters;
  const RelativeFactors now = factors(state.theta);
  for (std::size_t t = 0; t < now.size(); ++t) {
    state.spherical.push_back(
        spherical_effects(now[t], scaled_values(random_[t], fit.random[t].effects)));
  }
  const bool is_known = variance_.correlated() == nullptr || fit.variance.correlation;
  return is_known ? state : with_residuals(state).front();
}

bool LindstromBates::leave_boundary(const LindstromBatesOutcome& outcome,
                                    LindstromBatesState& inside) {
  if (!outcome.is_valid) return false;
  inside = outcome.state;
  adopt_units(inside.scale, inside.mixing);
  return leave_singular_covariance(outcome, inside) || leave_end_of_correlation(outcome, inside);
}

std::vector<VectorXd> LindstromBates::other_correlations(const VectorXd& now) const {
  const CorrelationStructure& structure = variance_.correlated()->structure();
  std::vector<VectorXd> others;
  if (structure.has_unbounded_range(now) || structure.lifted(now) != now) {
    // The likelihood has no slope at an end.
    others = structure.starts();
    for (std::size_t k = others.size(); k-- > 0;) {
      others.push_back(now);
      others.back()[0] = others[k][0];
    }
  } else if (has_kinked_range(variance_.correlated())) {
    constexpr double kStep = 0.01;
    constexpr int kSteps = 25;
    for (int k = -kSteps; k <= kSteps; ++k) {
      others.push_back(now);
      others.back()[0] += kStep * k;
    }
  }
  std::erase_if(others, [&](const VectorXd& of) { return structure.has_unbounded_range(of); });
  return others;
}

bool LindstromBates::leave_end_of_correlation(const LindstromBatesOutcome& outcome,
                                              LindstromBatesState& inside) {
  if (variance_.correlated() == nullptr) return false;
  Start best{.value = kInfinity};
  for (const VectorXd& other :
       other_correlations(variance_.correlation_part(variance_parameters(inside.theta)))) {
    LindstromBatesState trial = outcome.state;
    trial.theta.tail(other.size()) = other;
    Linearization at;
    if (!linearize(trial, nullptr, at)) continue;
    const LinearMixedProfile there = profile_at(at, trial.theta, false);
    if (there.is_valid && there.minus_log_likelihood < best.value)
      best = {trial.theta, there.minus_log_likelihood};
  }
  if (best.theta.size() == 0) return false;
  const QuasiNewtonResult end = best_theta(with_theta(outcome.state, best.theta), kRoughly);
  if (!(end.value < -outcome.log_likelihood - kRoundedLikelihood)) return false;
  inside = with_theta(outcome.state, end.x);
  return true;
}

bool LindstromBates::leave_singular_covariance(const LindstromBatesOutcome& outcome,
                                               LindstromBatesState& inside) {
  if (random_.empty()) return false;
  const LinearMixedProfile here = profile_at(*outcome.at, inside.theta, true);
  if (!here.is_valid) return false;
  const RelativeFactors now = factors(inside.theta);
  // The likelihood may increase along the parameters of each factor.
  bool is_higher = false;
  for_each_term([&](std::size_t t, const RelativeFactor& factor, Index begin) {
    VectorXd direction;
    for (double size = 1.0;
         !is_higher && rising_direction(here.by_covariance[t], direction) && size > 1e-7;
         size *= 0.1) {
      const MatrixXd moved = now[t] * now[t].transpose() + size * direction * direction.transpose();
      VectorXd theta = inside.theta;
      theta.segment(begin, factor.parameter_count()) = factor.from_covariance(moved);
      const LinearMixedProfile there = profile_at(*outcome.at, theta, false);
      is_higher = there.is_valid && there.minus_log_likelihood < here.minus_log_likelihood - 1e-6;
      if (is_higher) inside.theta = theta;
    }
  });
  if (!is_higher) return false;
  for (MatrixXd& of_term : inside.spherical) of_term.setZero();
  return true;
}

MixedEffectsFit LindstromBates::result(const LindstromBatesOutcome& outcome) {
  const LindstromBatesState& state = outcome.state;
  adopt_units(state.scale, state.mixing);
  const Linearization& at = *outcome.at;
  const LinearMixedProfile value = profile_at(at, state.theta, false);
  const RelativeFactors now = factors(state.theta);

  MixedEffectsFit fit;
  fit.estimate = own_values(all_, state.beta);
  const Index p = fit.estimate.size();
  const MatrixXd inverse = inverse_information(value);
  // nlme's factor for maximum-likelihood standard errors; restricted likelihood has it in sigma.
  const double adjusted =
      value.sum_of_squares / (static_cast<double>(model_.observations()) - static_cast<double>(p));
  fit.covariance = adjusted * own_values(all_, own_values(all_, inverse).transpose());
  for (std::size_t t = 0; t < now.size(); ++t) {
    const MatrixXd factor = own_values(random_[t], now[t]);
    fit.random.push_back({.covariance = value.sigma2 * factor * factor.transpose(),
                          .effects = factor * state.spherical[t]});
  }
  const double sigma = std::sqrt(value.sigma2);
  fit.sigma = sigma * variance_.sigma_factor(variance_parameters(state.theta));
  fit.variance = variance_.estimate(variance_parameters(state.theta));
  fit.log_likelihood = outcome.log_likelihood;
  fit.parameter_count =
      static_cast<int>(p + random_parameter_count() + variance_.parameter_count()) + 1;
  fit.observations = model_.observations();
  fit.fitted_conditional = at.mean;
  fit.fitted_population = model_.mean_at(fit.estimate);
  if (at.weight.size() > 0) {
    fit.residual_sd = sigma * at.weight.rsqrt();
  } else {
    fit.residual_sd = VectorXd::Constant(model_.observations(), sigma);
  }
  fit.convergence.status =
      outcome.converged ? ConvergenceStatus::kConverged : outcome.obstacle.status;
  fit.convergence.newton_decrement = std::max(outcome.decrement, outcome.curve_decrement);
  fit.convergence.iterations = outcome.iterations;
  fit.floored_variances = variance_.floored(at.mean);
  return fit;
}

}  // namespace silvafit::fit
