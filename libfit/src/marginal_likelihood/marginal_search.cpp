// SPDX-License-Identifier: MIT
#include "marginal_likelihood/marginal_search.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <optional>
#include <utility>

#include "least_squares/least_squares_verdict.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "mixed_effects/degenerate_fit.hpp"
#include "mixed_effects/expected_information.hpp"
#include "model/kinked_range.hpp"
#include "model/symmetric_eigen.hpp"
#include "optimization/kinked_minimum.hpp"
#include "optimization/tolerances.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// Newton decrement at which a search ends.
constexpr double kConvergedDecrement = 1e-10;
// Its steps go slightly closer; much closer, the descent is below rounding of the likelihood.
constexpr double kStopDecrement = 1e-11;
// The same if the descent is below rounding earlier.
constexpr double kRoundedStop = 1e-8;

VarianceData data_of(const NonlinearModel& model, const SharedClusters* shared) {
  VarianceData data = VarianceData::of(model);
  if (shared != nullptr) data.typical = shared->typical;
  return data;
}

/// Replaces the modes of clusters by other ones whose objective is lower by more than rounding.
/// \param objectives  the minimized objectives: of the modes, and of the others
/// \return            whether a mode was replaced
bool take_lower(const EffectLayout& layout,
                const VectorXd& others,
                const VectorXd& of_others,
                VectorXd& modes,
                VectorXd& objectives) {
  constexpr double kLower = 1e-6;
  bool any = false;
  for (Index c = 0; c < objectives.size(); ++c) {
    if (!(of_others[c] < objectives[c] - kLower)) continue;
    const Index begin = layout.begin(c);
    const Index size = layout.begin(c + 1) - begin;
    modes.segment(begin, size) = others.segment(begin, size);
    objectives[c] = of_others[c];
    any = true;
  }
  return any;
}

/// Further starts of the search for modes: no effects, and each effect far to either side.
std::vector<VectorXd> other_starts(const EffectLayout& layout) {
  const VectorXd none = VectorXd::Zero(layout.size());
  std::vector<VectorXd> starts{none};
  // Standard deviations.
  for (const double side : {2.0, -2.0, 1.0, -1.0}) {
    for (std::size_t t = layout.terms(); t-- > 0;) {
      for (Index k = 0; k < layout.count(t); ++k) {
        std::vector<MatrixXd> terms = layout.by_term(none);
        terms[t].row(k).setConstant(side);
        starts.push_back(layout.from_terms(terms));
      }
    }
  }
  return starts;
}

/// Turns slopes by the coefficients into those along the directions that change the curve as the
/// coefficients do elsewhere. Unlike the others, their derivatives at a point that is only near the
/// maximum hardly depend on coordinates, in which a small slope may change the curvature much.
/// \param there  (N x p) slopes of the curve elsewhere
/// \param here   (N x p) those at the point of the slopes
void turn(const MatrixXd& there, const MatrixXd& here, VectorXd& slopes) {
  if (!here.allFinite() || !there.allFinite()) return;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(here);
  if (qr.rank() < here.cols()) return;
  slopes.head(here.cols()) = (qr.solve(there).transpose() * slopes.head(here.cols())).eval();
}

}  // namespace

bool needs_curvature(Method method) { return curvature_of(method) == Curvature::kFull; }

MarginalSearch::MarginalSearch(const NonlinearModel& model,
                               Method method,
                               const MixedEffectsOptions& options,
                               const VectorXd& near,
                               const SharedClusters* shared)
    : model_(model),
      shared_(shared),
      options_(options),
      method_(method),
      variance_(model.specification().variance, data_of(model, shared)),
      likelihood_(model,
                  variance_,
                  curvature_of(method),
                  method == Method::kQuadrature ? options.quadrature_points : 1,
                  shared),
      coordinates_(model, variance_, shared != nullptr ? shared->frame : frame_at(model, near)) {}

void MarginalSearch::limit_search() {
  is_limited_ = true;
  rounds_ = 3;
  steps_ = 30;
  short_steps_ = 3;
  most_evaluations_ = 100 + 20 * static_cast<int>(coordinates_.layout().size());
}

void MarginalSearch::try_fit(const MixedEffectsFit& fit) {
  if (!std::isfinite(fit.sigma) || !(fit.sigma > 0.0)) return;
  const VectorXd x = coordinates_of(fit);
  run(x, modes_of(fit, x));
}

void MarginalSearch::try_pooled(const VectorXd& beta) {
  const double residual_sd = std::sqrt((model_.response() - model_.mean_at(beta)).squaredNorm() /
                                       static_cast<double>(model_.observations()));
  for (const double spread : {0.3, 0.03, 1.0}) {
    try_spread(beta, residual_sd, spread);
    if (has_converged() || (is_limited_ && has_optimum())) break;
  }
}

double MarginalSearch::value_of(const MixedEffectsFit& fit) {
  const VectorXd x = coordinates_of(fit);
  if (!x.allFinite()) return kNaN;
  likelihood_.set_modes(modes_of(fit, x));
  const double value = value_at(x, nullptr);
  return std::isfinite(value) ? -value : kNaN;
}

bool MarginalSearch::is_out_of_scale(const MixedEffectsFit& fit) const {
  auto [mean, jacobian] = model_.curve_at(fit.estimate);
  jacobian *= coordinates_.layout().frame().beta;
  const Eigen::ArrayXd ratio = jacobian.colwise().norm() / (model_.response() - mean).norm();
  constexpr double kUnsuitable = 4.0;
  return (ratio > kUnsuitable || ratio < 1.0 / kUnsuitable).any();
}

Obstacle MarginalSearch::obstacle() const {
  Obstacle result = ended_by();
  result.moving = moving();
  return result;
}

MixedEffectsFit MarginalSearch::result() {
  const MarginalPoint point = coordinates_.point(best_.x);
  MixedEffectsFit fit;
  fit.estimate = coordinates_.layout().beta(best_.x);
  set_covariance(best_.hessian, fit);
  const std::vector<MatrixXd> spherical = likelihood_.layout().by_term(best_.modes);
  for (std::size_t t = 0; t < spherical.size(); ++t) {
    const MatrixXd& factor = point.factors[t];
    fit.random.push_back(
        {.covariance = factor * factor.transpose(), .effects = factor * spherical[t]});
  }
  const VectorXd& parameters = point.observation.variance;
  const double scale = std::exp(point.observation.log_sigma);
  fit.sigma = scale * variance_.sigma_factor(parameters);
  fit.variance = variance_.estimate(parameters);
  fit.log_likelihood = -best_.value;
  fit.parameter_count = static_cast<int>(coordinates_.layout().size());
  fit.observations = shared_ != nullptr ? shared_->observations : model_.observations();
  fill_in_fitted(model_, variance_, scale, parameters, fit);
  if (has_converged()) fit.convergence.status = ConvergenceStatus::kConverged;
  if (best_.kinks.size() > 0) {
    const MatrixXd& frame = coordinates_.layout().frame().beta;
    fit.convergence.add(Evidence::Kind::kKink,
                        names_of(model_, kinked_coefficients(frame, best_.kinks)));
  }
  fit.convergence.newton_decrement = best_.decrement;
  fit.convergence.iterations = evaluations_;
  return fit;
}

void MarginalSearch::try_spread(const VectorXd& beta, double residual_sd, double spread) {
  const VectorXd parameters = variance_.constant();
  const ObservationPoint observation{
      .beta = beta, .variance = parameters, .log_sigma = std::log(residual_sd)};
  std::vector<MatrixXd> covariances;
  for (const MatrixXd& unit : coordinates_.layout().frame().effects) {
    covariances.emplace_back(spread * spread * unit * unit.transpose());
  }
  run(coordinates_.coordinates(observation, covariances),
      VectorXd::Zero(likelihood_.layout().size()));
}

VectorXd MarginalSearch::coordinates_of(const MixedEffectsFit& fit) const {
  const VectorXd parameters = variance_.parameters(fit.variance);
  const ObservationPoint observation{
      .beta = fit.estimate,
      .variance = parameters,
      .log_sigma = std::log(fit.sigma / variance_.sigma_factor(parameters))};
  return coordinates_.coordinates(observation, covariances_of(fit));
}

VectorXd MarginalSearch::modes_of(const MixedEffectsFit& fit, const VectorXd& x) const {
  return likelihood_.layout().from_terms(coordinates_.spherical(x, effects_of(fit)));
}

Obstacle MarginalSearch::ended_by() const {
  constexpr int kOften = 20;
  if (needs_curvature(method_) && (outside_ > kOften || best_.is_blocked)) {
    return {.status = ConvergenceStatus::kInvalidApproximation,
            .cause = Finding::Kind::kNoClearMode};
  }
  if (is_exhausted()) {
    return {.status = ConvergenceStatus::kIterationLimit, .cause = Finding::Kind::kEvaluationLimit};
  }
  if (best_.is_blocked) return {.cause = Finding::Kind::kJumps};
  return {};
}

std::string MarginalSearch::moving() const {
  const VectorXd step = informed_inverse(best_.hessian) * best_.gradient;
  Index at = 0;
  if (!step.allFinite() || step.cwiseAbs().maxCoeff(&at) == 0.0) return {};
  return coordinates_.layout().name(model_, at);
}

void MarginalSearch::check_progress(double lowest) {
  if (evaluations_ < next_check_ || !std::isfinite(lowest)) return;
  constexpr int kSteps = 10;
  constexpr double kNear = 0.05;
  const int pace = kSteps + 2 * static_cast<int>(coordinates_.layout().size());
  const double left = static_cast<double>(most_evaluations_ - evaluations_) / pace;
  const double gap = lowest - known_;
  is_too_slow_ = next_check_ > 0 && gap > kNear && gap > left * (value_at_last_check_ - lowest);
  value_at_last_check_ = lowest;
  next_check_ = evaluations_ + pace;
}

double MarginalSearch::value_at(const VectorXd& x, VectorXd* gradient) {
  ++evaluations_;
  const MarginalValue value = likelihood_.evaluate(coordinates_.point(x), gradient != nullptr);
  if (gradient != nullptr) *gradient = coordinates_.gradient(x, value);
  if (!std::isfinite(value.minus_log_likelihood)) ++outside_;
  if (options_.trace) {
    options_.trace(fmt::format(
        "evaluation {:4}  log-likelihood {:.8f}", evaluations_, -value.minus_log_likelihood));
  }
  return value.minus_log_likelihood;
}

void MarginalSearch::run(const VectorXd& start, VectorXd modes) {
  if (!start.allFinite()) return;
  likelihood_.set_modes(std::move(modes));
  Optimum optimum = searched(start);
  constexpr int kWidenings = 3;
  for (int k = 0; k < kWidenings && std::isfinite(optimum.value) && !is_exhausted(); ++k) {
    const VectorXd inside = inside_of(optimum);
    if (inside.size() == 0) break;
    Optimum other = searched(inside);
    if (!(other.value < optimum.value - kRoundedLikelihood)) break;
    optimum = std::move(other);
  }
  constexpr int kCorrections = 3;
  for (int k = 0; k < kCorrections && std::isfinite(optimum.value); ++k) {
    if (is_too_slow_ || !finds_higher_modes(optimum)) break;
    optimum = searched(optimum.x);
  }
  if (is_too_slow_) return;
  const bool is_same = optimum.value < best_.value + kRoundedLikelihood;
  const bool is_surer = is_same && optimum.decrement < best_.decrement;
  if (optimum.value < best_.value - kRoundedLikelihood || is_surer) best_ = std::move(optimum);
}

bool MarginalSearch::finds_higher_modes(const Optimum& optimum) {
  // The modes of the first-order method are those of another density.
  if (method_ == Method::kFirstOrder) return false;
  const MarginalPoint point = coordinates_.point(optimum.x);
  VectorXd highest = optimum.modes;
  std::optional<VectorXd> lowest = likelihood_.find_modes(point, highest, nullptr);
  if (!lowest) return false;
  bool is_better = false;
  for (VectorXd& start : other_starts(likelihood_.layout())) {
    ++evaluations_;
    const auto objectives = likelihood_.find_modes(point, start, &highest);
    if (objectives && take_lower(likelihood_.layout(), start, *objectives, highest, *lowest))
      is_better = true;
  }
  likelihood_.set_modes(std::move(highest));
  return shared_ != nullptr ? is_on_any_rank(is_better) : is_better;
}

MarginalSearch::Optimum MarginalSearch::searched(const VectorXd& start) {
  // Modes are searched from those of the lowest point: those of a refused step may belong to
  // another maximum of the density of the random effects.
  const VectorXd first = likelihood_.modes();
  double lowest = kInfinity;
  const SmoothFunction function = [&](const VectorXd& x, VectorXd* gradient) {
    if (std::isfinite(lowest)) {
      likelihood_.set_kept_modes();
    } else {
      likelihood_.set_modes(first);
    }
    const double value = value_at(x, gradient);
    if (value < lowest) {
      lowest = value;
      likelihood_.keep_modes(coordinates_.point(x));
    }
    return value;
  };
  // After the last allowed evaluation all further steps are refused.
  const SmoothFunction objective = [&](const VectorXd& x, VectorXd* gradient) {
    check_progress(lowest);
    return is_exhausted() ? kInfinity : function(x, gradient);
  };
  Optimum optimum;
  const auto minimum_from = [&](const VectorXd& x, const MatrixXd& curvature, int steps) {
    return minimize(objective,
                    x,
                    curvature,
                    {.decrement = kStopDecrement,
                     .rounded_decrement = kRoundedStop,
                     .maximum_steps = steps,
                     .most_short_steps = short_steps_,
                     .one_sided = curvature.size() == 0});
  };
  QuasiNewtonResult found = minimum_from(start, {}, 2 * steps_);
  MatrixXd hessian;
  double last = kInfinity;
  for (int round = 0; round < rounds_ && std::isfinite(found.value) && !is_too_slow_; ++round) {
    // The certificate uses the true Hessian, not that of the quasi-Newton updates.
    VectorXd gradient;
    optimum.x = found.x;
    optimum.value = function(found.x, &gradient);
    optimum.modes = likelihood_.modes();
    // A correction that is much shorter than a standard error hardly changes it.
    if (!(last < kReachedDecrement)) hessian = one_sided_hessian(function, found.x, gradient);
    const CurvatureCertificate certificate(hessian, gradient);
    optimum.hessian = 0.5 * (hessian + hessian.transpose());
    optimum.decrement = certificate.decrement();
    optimum.gradient = gradient;
    optimum.is_blocked = found.is_blocked;
    if (is_exhausted() || found.is_blocked) break;
    const VectorXd lower = lower_point(optimum, certificate);
    if (lower.size() > 0) {
      last = kInfinity;
      found = minimum_from(lower, {}, steps_);
    } else if (optimum.decrement <= kConvergedDecrement ||
               (optimum.decrement <= kReachedDecrement && optimum.decrement > 0.5 * last)) {
      break;
    } else {
      last = optimum.decrement;
      found = minimum_from(found.x, optimum.hessian, steps_);
    }
  }
  if (optimum.decrement > kConvergedDecrement && has_kinks()) settle_at_kinks(objective, optimum);
  return optimum;
}

bool MarginalSearch::has_kinks() const {
  return !model_.fixed_kinks().empty() || has_kinked_range(variance_.correlated());
}

void MarginalSearch::settle_at_kinks(const SmoothFunction& function, Optimum& optimum) const {
  if (is_too_slow_ || !std::isfinite(optimum.value)) return;
  const auto found = minimum_at_kinks(function, optimum.x);
  if (!found || !(found->value <= optimum.value + kRoundedLikelihood)) return;
  optimum.x = found->x;
  optimum.value = found->value;
  optimum.gradient = found->gradient;
  optimum.hessian = found->hessian;
  optimum.decrement = found->decrement;
  optimum.kinks = found->normals;
  optimum.modes = likelihood_.modes();
  optimum.is_blocked = false;
}

VectorXd MarginalSearch::lower_point(const Optimum& optimum,
                                     const CurvatureCertificate& certificate) {
  const VectorXd& direction = certificate.downwards();
  if (direction.size() == 0) return {};
  for (const double size : {1.0, 0.3, 0.1, 0.03}) {
    for (const double sign : {1.0, -1.0}) {
      VectorXd x = optimum.x + sign * size * direction;
      if (value_at(x, nullptr) < optimum.value - kRoundedLikelihood) return x;
      likelihood_.set_modes(optimum.modes);
    }
  }
  return {};
}

VectorXd MarginalSearch::inside_of(const Optimum& optimum) {
  for (std::size_t term = model_.term_count(); term-- > 0;) {
    const MatrixXd covariance = coordinates_.scaled_covariance(optimum.x, term);
    const SymmetricEigen of = symmetric_eigen(covariance);
    constexpr double kEdge = 1e-4;
    for (Index k = 0; k < covariance.rows() && of.values[k] < kEdge; ++k) {
      for (const double size : {0.1, 1e-3}) {
        VectorXd inside = coordinates_.widened(optimum.x, term, of.vectors.col(k), size);
        likelihood_.set_modes(optimum.modes);
        if (value_at(inside, nullptr) < optimum.value - kRoundedLikelihood) return inside;
      }
    }
  }
  likelihood_.set_modes(optimum.modes);
  return {};
}

void MarginalSearch::set_covariance(const MatrixXd& hessian, MixedEffectsFit& fit) const {
  const SurfaceLayout& layout = coordinates_.layout();
  MatrixXd transform = MatrixXd::Zero(layout.beta_count(), layout.size());
  transform.leftCols(layout.beta_count()) = layout.frame().beta;
  InformedCovariance of = informed_covariance(hessian, transform);
  fit.covariance = std::move(of.covariance);
  fit.convergence.rank = static_cast<int>(layout.beta_count() - of.unknown_directions);
}

MatrixXd MarginalSearch::curve_slopes(const VectorXd& x) const {
  const SurfaceLayout& layout = coordinates_.layout();
  return model_.curve_at(model_.extended(layout.beta(x))).jacobian.leftCols(layout.beta_count()) *
         layout.frame().beta;
}

std::optional<MatrixXd> MarginalSearch::accurate_hessian(const MixedEffectsFit& fit) {
  const VectorXd x = coordinates_of(fit);
  likelihood_.set_modes(modes_of(fit, x));
  VectorXd gradient;
  if (!std::isfinite(value_at(x, &gradient))) return std::nullopt;
  likelihood_.keep_modes(coordinates_.point(x));
  const bool is_jagged = !model_.random_kinks().empty();
  const MatrixXd directions = shared_ != nullptr || is_jagged ? MatrixXd() : curve_slopes(x);
  const SmoothFunction function = [&](const VectorXd& at, VectorXd* slopes) {
    likelihood_.set_kept_modes();
    const double value = value_at(at, slopes);
    if (slopes != nullptr && directions.size() > 0) turn(directions, curve_slopes(at), *slopes);
    return value;
  };
  return is_jagged ? hessian_over_errors(function, x, gradient)
                   : hessian_from_gradients(function, x, gradient);
}

void MarginalSearch::compute_errors(MixedEffectsFit& fit) {
  // Without quadrature the likelihood jumps at kinks that random effects move, as its message says.
  const bool has_kinks = !model_.random_kinks().empty();
  const bool is_by_quadrature = method_ == Method::kQuadrature;
  bool has_curvature = true;
  if (!has_kinks || is_by_quadrature) {
    const auto hessian = accurate_hessian(fit);
    has_curvature = !hessian || is_of_minimum(*hessian);
    if (hessian && (has_kinks || has_curvature)) set_covariance(*hessian, fit);
  }
  // A direction without curvature is one of coefficients that are not identifiable. Negative
  // curvature at a maximum is due to rounding errors of the slopes, or to too few steps in them.
  if (fit.covariance.allFinite() || (!has_kinks && has_curvature)) return;
  fit.covariance = expected_covariance(model_,
                                       fit,
                                       group_coefficients(model_, fit),
                                       fit.residual_sd,
                                       coordinates_.layout().frame().beta);
  fit.convergence.rank = static_cast<int>(coordinates_.layout().beta_count());
  if (!has_kinks) fit.convergence.find({.kind = Finding::Kind::kExpectedErrors});
  if (has_kinks && is_by_quadrature) {
    fit.convergence.add(Evidence::Kind::kKink, model_.random_kinks());
  }
}

void fill_in_fitted(const NonlinearModel& model,
                    const VarianceModel& variance,
                    double scale,
                    const VectorXd& parameters,
                    MixedEffectsFit& fit) {
  fit.fitted_population = model.mean_at(fit.estimate);
  fit.fitted_conditional = model.mean_at(group_coefficients(model, fit));
  const ResidualScale residual = variance.scale(fit.fitted_conditional, parameters, false);
  fit.residual_sd = scale * residual.weight.rsqrt();
  fit.floored_variances = variance.floored(fit.fitted_conditional);
}

}  // namespace silvafit::fit
