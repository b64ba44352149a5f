// SPDX-License-Identifier: MIT
// Maximum marginal likelihood: starts, the search, its evidence, and the result.
#include "marginal_likelihood/marginal_fit.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "likelihood/marginal_coordinates.hpp"
#include "likelihood/marginal_likelihood.hpp"
#include "likelihood/other_modes.hpp"
#include "mixed_effects/degenerate_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/symmetric_eigen.hpp"
#include "model/variance_weights.hpp"
#include "optimization/curvature_certificate.hpp"
#include "optimization/quasi_newton.hpp"
#include "result/group_coefficients.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Squared distance to the optimum in standard errors at which a fit has converged.
constexpr double kConvergedDecrement = 1e-10;
// The same where rounding of gradients keeps a search from coming closer, as with random slopes on
// a covariate far from its origin.
constexpr double kReachedDecrement = 1e-6;
// The search stops a little closer; much closer, rounding of the likelihood hides all descent.
constexpr double kStopDecrement = 1e-11;
// The same where rounding is seen to hide it before.
constexpr double kRoundedStop = 1e-8;
// Two log-likelihoods that differ by less are the same but for rounding.
constexpr double kSameLikelihood = 1e-6;

Curvature curvature_of(Integration integration) {
  switch (integration) {
    case Integration::kFirstOrder:
      return Curvature::kFirstOrder;
    case Integration::kInteraction:
      return Curvature::kExpected;
    default:
      return Curvature::kFull;
  }
}

/// Whether the likelihood has the true curvature at the modes, which need not be positive
/// elsewhere.
bool needs_curvature(Integration integration) {
  return curvature_of(integration) == Curvature::kFull;
}

/// Where a search ended.
struct Optimum {
  VectorXd x{};
  double value = std::numeric_limits<double>::infinity();
  double decrement = std::numeric_limits<double>::infinity();
  VectorXd gradient{};
  MatrixXd hessian{};
  bool is_blocked = false;  ///< whether only very short steps led on
  Modes modes{};
};

class MarginalSearch {
 public:
  MarginalSearch(const NonlinearModel& model,
                 Integration integration,
                 const MarginalOptions& options,
                 const MixedEffectsFit& linearized)
      : model_(model),
        options_(options),
        integration_(integration),
        variance_(model.specification().variance, VarianceData::of(model)),
        likelihood_(model,
                    variance_,
                    curvature_of(integration),
                    integration == Integration::kQuadrature ? options.quadrature_points : 1),
        coordinates_(model, variance_, frame_at(model, linearized.estimate)) {}

  /// Limits the iterations where other starts follow: near the maximum rounding can hide all
  /// descent, and a search that fails costs more than a start from scratch.
  void limit_search() {
    rounds_ = 3;
    steps_ = 30;
    short_steps_ = 3;
    most_evaluations_ = 100 + 20 * static_cast<int>(coordinates_.layout().size());
  }

  /// Stops where it falls behind a log-likelihood that another search has reached.
  void race(double known) { known_ = -known; }

  /// From a fit by another method.
  void try_fit(const MixedEffectsFit& fit) {
    if (!std::isfinite(fit.sigma) || !(fit.sigma > 0.0)) return;
    const VectorXd x = coordinates_of(fit);
    run(x, modes_of(fit, x));
  }

  /// From the pooled fit with random effects of several spreads, until one converges.
  void try_pooled(const VectorXd& beta) {
    NonlinearModel::Workspace workspace;
    VectorXd mean;
    model_.evaluate(beta, mean, nullptr, workspace);
    const double residual_sd = std::sqrt((model_.response() - mean).squaredNorm() /
                                         static_cast<double>(model_.observations()));
    for (const double spread : {0.3, 0.03, 1.0}) {
      try_spread(beta, residual_sd, spread);
      if (has_converged()) break;
    }
  }

  /// The log-likelihood at a fit by another method; NaN where it does not hold.
  double value_of(const MixedEffectsFit& fit) {
    const VectorXd x = coordinates_of(fit);
    if (!x.allFinite()) return std::numeric_limits<double>::quiet_NaN();
    likelihood_.set_modes(modes_of(fit, x));
    const double value = value_at(x, nullptr);
    return std::isfinite(value) ? -value : std::numeric_limits<double>::quiet_NaN();
  }

  bool has_optimum() const { return std::isfinite(best_.value); }
  bool has_converged() const { return has_optimum() && best_.decrement <= kReachedDecrement; }

  /// Whether a unit of the search does not move the mean at a fit by about one residual standard
  /// deviation.
  bool is_out_of_scale(const MixedEffectsFit& fit) const {
    NonlinearModel::Workspace workspace;
    VectorXd mean;
    MatrixXd jacobian;
    model_.evaluate(fit.estimate, mean, &jacobian, workspace);
    jacobian *= coordinates_.layout().frame().beta;
    const VectorXd ratio = jacobian.colwise().norm() / (model_.response() - mean).norm();
    constexpr double kUnsuitable = 4.0;
    return ratio.maxCoeff() > kUnsuitable || ratio.minCoeff() < 1.0 / kUnsuitable;
  }

  /// What ended the search short of a maximum, and where it would go.
  Obstacle obstacle() const {
    Obstacle result = ended_by();
    result.moving = moving();
    return result;
  }

  MixedEffectsFit result() {
    const MarginalPoint point = coordinates_.point(best_.x);
    MixedEffectsFit fit;
    fit.estimate = point.observation.beta;
    fit.covariance = fixed_covariance();
    fit.random.resize(model_.specification().random.size());
    fit.random.back().covariance = point.inner_factor * point.inner_factor.transpose();
    fit.random.back().effects = point.inner_factor * best_.modes.inner;
    if (outer_count() > 0) {
      fit.random.front().covariance = point.outer_factor * point.outer_factor.transpose();
      fit.random.front().effects = point.outer_factor * best_.modes.outer;
    }
    const VectorXd& parameters = point.observation.variance;
    const double scale = std::exp(point.observation.log_sigma);
    fit.sigma = scale * variance_.sigma_factor(parameters);
    fit.variance = variance_.estimate(parameters);
    fit.log_likelihood = -best_.value;
    fit.parameter_count = static_cast<int>(coordinates_.layout().size());
    fit.observations = model_.observations();
    predict(fit, scale, parameters);
    if (has_converged()) fit.convergence.status = ConvergenceStatus::kConverged;
    fit.convergence.newton_decrement = best_.decrement;
    fit.convergence.iterations = evaluations_;
    return fit;
  }

 private:
  /// \param spread  of the random effects, a share of the residuals' own
  void try_spread(const VectorXd& beta, double residual_sd, double spread) {
    const VectorXd parameters = variance_.constant();
    const ObservationPoint observation{
        .beta = beta, .variance = parameters, .log_sigma = std::log(residual_sd)};
    const auto covariance = [&](bool is_outer) -> MatrixXd {
      const MatrixXd& unit = coordinates_.layout().frame().effects(is_outer);
      return spread * spread * unit * unit.transpose();
    };
    const VectorXd x = coordinates_.coordinates(observation, covariance(true), covariance(false));
    run(x,
        {.outer = MatrixXd::Zero(outer_count(), model_.cluster_count()),
         .inner = MatrixXd::Zero(inner_count(), model_.group_count())});
  }

  VectorXd coordinates_of(const MixedEffectsFit& fit) const {
    const VectorXd parameters = variance_.parameters(fit.variance);
    const ObservationPoint observation{
        .beta = fit.estimate,
        .variance = parameters,
        .log_sigma = std::log(fit.sigma / variance_.sigma_factor(parameters))};
    return coordinates_.coordinates(observation, outer_of(fit), finer(fit).covariance);
  }

  Index outer_count() const { return static_cast<Index>(likelihood_.places().outer.size()); }
  Index inner_count() const { return static_cast<Index>(likelihood_.places().inner.size()); }

  MatrixXd outer_of(const MixedEffectsFit& fit) const {
    return outer_count() > 0 ? coarser(fit).covariance : MatrixXd(0, 0);
  }
  /// The modes that a fit by another method has at x.
  Modes modes_of(const MixedEffectsFit& fit, const VectorXd& x) const {
    const MatrixXd outer =
        outer_count() > 0 ? coarser(fit).effects : MatrixXd(0, model_.cluster_count());
    return {.outer = coordinates_.spherical(x, true, outer),
            .inner = coordinates_.spherical(x, false, finer(fit).effects)};
  }

  /// What ended the search short of a maximum.
  Obstacle ended_by() const {
    constexpr int kOften = 20;
    if (needs_curvature(integration_) && (outside_ > kOften || best_.is_blocked)) {
      return {.status = ConvergenceStatus::kInvalidApproximation,
              .text = std::string(kNoClearMode)};
    }
    if (is_exhausted()) {
      return {.status = ConvergenceStatus::kIterationLimit,
              .text = "the evaluation limit is reached"};
    }
    if (best_.is_blocked) {
      return {.text = "the likelihood has a jump, because the conditional mode of a group changes"};
    }
    return {};
  }

  /// The parameter that moves most on the way to where the quadratic around the best point has its
  /// minimum, by what it does to the mean.
  std::string moving() const {
    const VectorXd step = informed_inverse(best_.hessian) * best_.gradient;
    Index at = 0;
    if (!step.allFinite() || step.cwiseAbs().maxCoeff(&at) == 0.0) return {};
    return coordinates_.layout().name(model_, at);
  }

  bool is_exhausted() const { return is_hopeless_ || evaluations_ >= most_evaluations_; }

  /// Notes whether the evaluations that are left would lead to the known maximum, at the pace of
  /// the last ones: as many as a first Hessian and some steps take.
  void watch_pace(double lowest) {
    if (evaluations_ < next_look_ || !std::isfinite(lowest)) return;
    constexpr int kSteps = 10;
    constexpr double kNear = 0.05;
    const int pace = kSteps + 2 * static_cast<int>(coordinates_.layout().size());
    const double left = static_cast<double>(most_evaluations_ - evaluations_) / pace;
    const double gap = lowest - known_;
    is_hopeless_ = next_look_ > 0 && gap > kNear && gap > left * (last_look_ - lowest);
    last_look_ = lowest;
    next_look_ = evaluations_ + pace;
  }

  double value_at(const VectorXd& x, VectorXd* gradient) {
    ++evaluations_;
    const MarginalValue value = likelihood_.evaluate(coordinates_.point(x), gradient != nullptr);
    if (gradient != nullptr) *gradient = coordinates_.gradient(value);
    if (!std::isfinite(value.minus_log_likelihood)) ++outside_;
    if (options_.trace) {
      options_.trace(fmt::format(
          "evaluation {:4}  log-likelihood {:.8f}", evaluations_, -value.minus_log_likelihood));
    }
    return value.minus_log_likelihood;
  }

  void run(const VectorXd& start, Modes modes) {
    if (!start.allFinite()) return;
    likelihood_.set_modes(std::move(modes));
    Optimum optimum = searched(start);
    constexpr int kWidenings = 3;
    for (int k = 0; k < kWidenings && std::isfinite(optimum.value) && !is_exhausted(); ++k) {
      const VectorXd inside = inside_of(optimum);
      if (inside.size() == 0) break;
      Optimum other = searched(inside);
      if (!(other.value < optimum.value - kSameLikelihood)) break;
      optimum = std::move(other);
    }
    constexpr int kCorrections = 3;
    for (int k = 0; k < kCorrections && std::isfinite(optimum.value); ++k) {
      if (is_hopeless_ || !finds_higher_modes(optimum)) break;
      optimum = searched(optimum.x);
    }
    if (is_hopeless_) return;
    const bool is_same = optimum.value < best_.value + kSameLikelihood;
    const bool is_surer = is_same && optimum.decrement < best_.decrement;
    if (optimum.value < best_.value - kSameLikelihood || is_surer) best_ = std::move(optimum);
  }

  /// Looks elsewhere for modes, which a search follows from one point to the next and may have
  /// lost, and begins with the highest ones from now on.
  bool finds_higher_modes(const Optimum& optimum) {
    // The first-order method has modes of another density.
    if (integration_ == Integration::kFirstOrder) return false;
    const MarginalPoint point = coordinates_.point(optimum.x);
    Modes highest = optimum.modes;
    std::optional<VectorXd> lowest = likelihood_.find_modes(point, highest, nullptr);
    if (!lowest) return false;
    bool is_better = false;
    for (Modes& start : other_starts(highest)) {
      ++evaluations_;
      const auto objectives = likelihood_.find_modes(point, start, &highest);
      if (objectives && take_lower(model_, start, *objectives, highest, *lowest)) is_better = true;
    }
    likelihood_.set_modes(std::move(highest));
    return is_better;
  }

  Optimum searched(const VectorXd& start) {
    // Modes are searched from those of the lowest point: those of a step that was refused may
    // belong to another hill of the density of the random effects.
    const Modes first = likelihood_.modes();
    double lowest = std::numeric_limits<double>::infinity();
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
    // Once the search has had its evaluations, all further steps are refused.
    const SmoothFunction objective = [&](const VectorXd& x, VectorXd* gradient) {
      watch_pace(lowest);
      return is_exhausted() ? std::numeric_limits<double>::infinity() : function(x, gradient);
    };
    Optimum optimum;
    QuasiNewtonResult found = minimize(objective,
                                       start,
                                       {},
                                       {.decrement = kStopDecrement,
                                        .rounded_decrement = kRoundedStop,
                                        .maximum_steps = 2 * steps_,
                                        .most_short_steps = short_steps_,
                                        .one_sided = true});
    double last = std::numeric_limits<double>::infinity();
    for (int round = 0; round < rounds_ && std::isfinite(found.value) && !is_hopeless_; ++round) {
      // The certificate is the true Hessian's, not that of the updates on the way.
      VectorXd gradient;
      optimum.x = found.x;
      optimum.value = function(found.x, &gradient);
      optimum.modes = likelihood_.modes();
      const MatrixXd hessian = one_sided_hessian(function, found.x, gradient);
      const CurvatureCertificate certificate(hessian, gradient);
      optimum.hessian = 0.5 * (hessian + hessian.transpose());
      optimum.decrement = certificate.decrement();
      optimum.gradient = gradient;
      optimum.is_blocked = found.is_blocked;
      if (is_exhausted() || found.is_blocked) break;
      const VectorXd lower = lower_point(optimum, certificate);
      if (lower.size() > 0) {
        found = minimize(objective,
                         lower,
                         {},
                         {.decrement = kStopDecrement,
                          .rounded_decrement = kRoundedStop,
                          .maximum_steps = steps_,
                          .most_short_steps = short_steps_,
                          .one_sided = true});
      } else if (optimum.decrement <= kConvergedDecrement) {
        break;
      } else if (optimum.decrement <= kReachedDecrement && optimum.decrement > 0.5 * last) {
        break;
      } else {
        last = optimum.decrement;
        found = minimize(objective,
                         found.x,
                         optimum.hessian,
                         {.decrement = kStopDecrement,
                          .rounded_decrement = kRoundedStop,
                          .maximum_steps = steps_,
                          .most_short_steps = short_steps_});
      }
    }
    return optimum;
  }

  /// A point below a saddle, along its direction of negative curvature; nothing if there is none.
  VectorXd lower_point(const Optimum& optimum, const CurvatureCertificate& certificate) {
    const VectorXd& direction = certificate.downwards();
    if (direction.size() == 0) return {};
    for (const double size : {1.0, 0.3, 0.1, 0.03}) {
      for (const double sign : {1.0, -1.0}) {
        VectorXd x = optimum.x + sign * size * direction;
        if (value_at(x, nullptr) < optimum.value - kSameLikelihood) return x;
        likelihood_.set_modes(optimum.modes);
      }
    }
    return {};
  }

  /// If the covariance is singular although the likelihood increases towards the interior, a point
  /// inside; else nothing. At the boundary the gradient is zero by symmetry.
  VectorXd inside_of(const Optimum& optimum) {
    for (const bool is_outer : {false, true}) {
      const MatrixXd covariance = coordinates_.scaled_covariance(optimum.x, is_outer);
      if (covariance.size() == 0) continue;
      const SymmetricEigen of = symmetric_eigen(covariance);
      constexpr double kEdge = 1e-4;
      for (Index k = 0; k < covariance.rows() && of.values[k] < kEdge; ++k) {
        for (const double size : {0.1, 1e-3}) {
          VectorXd inside = coordinates_.widened(optimum.x, is_outer, of.vectors.col(k), size);
          likelihood_.set_modes(optimum.modes);
          if (value_at(inside, nullptr) < optimum.value - kSameLikelihood) return inside;
        }
      }
    }
    likelihood_.set_modes(optimum.modes);
    return {};
  }

  /// The fixed effects' block of the inverse of the observed information.
  MatrixXd fixed_covariance() const {
    const Index p = coordinates_.layout().beta_count();
    const MatrixXd& frame = coordinates_.layout().frame().beta;
    return frame * informed_inverse(best_.hessian).topLeftCorner(p, p) * frame.transpose();
  }

  void predict(MixedEffectsFit& fit, double scale, const VectorXd& parameters) const {
    NonlinearModel::Workspace workspace;
    model_.evaluate(fit.estimate, fit.fitted_population, nullptr, workspace);
    MatrixXd coefficients = fit.estimate.replicate(1, model_.group_count());
    add_group_effects(model_,
                      {.rows = likelihood_.places().inner, .effects = finer(fit).effects},
                      {.rows = likelihood_.places().outer, .effects = coarser(fit).effects},
                      coefficients);
    model_.evaluate(coefficients, fit.fitted_conditional, nullptr, workspace);
    const ResidualScale residual = variance_.scale(fit.fitted_conditional, parameters, false);
    fit.residual_sd = scale * residual.weight.rsqrt();
    fit.floored_variances = variance_.floored(fit.fitted_conditional);
  }

  const NonlinearModel& model_;
  const MarginalOptions& options_;
  Integration integration_;
  VarianceModel variance_;
  MarginalLikelihood likelihood_;
  MarginalCoordinates coordinates_;
  Optimum best_;
  int rounds_ = 6;        ///< of a search and its certificate
  int steps_ = 100;       ///< of a search within a round
  int short_steps_ = 10;  ///< in a row that end a search
  int most_evaluations_ = 500 + 50 * static_cast<int>(coordinates_.layout().size());
  int evaluations_ = 0;
  double known_ = std::numeric_limits<double>::infinity();  ///< value of a minimum known elsewhere
  double last_look_ = std::numeric_limits<double>::infinity();
  int next_look_ = 0;
  bool is_hopeless_ = false;
  int outside_ = 0;  ///< evaluations at points where the likelihood does not hold
};

}  // namespace

namespace {

/// The result, in units of the end of the search: if the start was far away, differences in its
/// units do not measure the curvature at the end.
MixedEffectsFit result_of(MarginalSearch& search,
                          const NonlinearModel& model,
                          Integration integration,
                          const MarginalOptions& options,
                          bool is_complete) {
  MixedEffectsFit fit = search.result();
  if (!search.is_out_of_scale(fit)) return fit;
  MarginalSearch anew(model, integration, options, fit);
  if (!is_complete) anew.limit_search();
  anew.try_fit(fit);
  if (!anew.has_optimum()) return fit;
  MixedEffectsFit again = anew.result();
  const bool is_as_good = again.log_likelihood > fit.log_likelihood - kSameLikelihood;
  return is_as_good && (anew.has_converged() || !search.has_converged()) ? again : fit;
}

/// What is left where the likelihood with curvature has no valid point near that without it.
MixedEffectsFit without_clear_modes(const NonlinearModel& model, MixedEffectsFit fit) {
  describe(model, fit);
  judge(model, fit, Rounds::kEvaluations);
  if (has_no_maximum(model, fit)) return fit;
  fit.convergence.status = ConvergenceStatus::kInvalidApproximation;
  fit.convergence.verdict =
      "Not converged: at the estimates of focei, which are shown, the conditional density of a "
      "group's random effects is flat at its mode, so the likelihood of this method is not valid "
      "there. Use --method focei, or fewer random effects.";
  return fit;
}

MixedEffectsFit without_modes(const NonlinearModel& model, MixedEffectsFit linearized) {
  // The linear model's search says better why it could not begin, or what it ran into.
  if (std::isnan(linearized.sigma) || has_no_maximum(model, linearized)) return linearized;
  linearized.convergence.status = ConvergenceStatus::kInvalidApproximation;
  linearized.convergence.verdict =
      "Not converged: no conditional mode of the random effects was found from any start. Use "
      "fewer random effects, or a model that fits the pooled data better.";
  return linearized;
}

}  // namespace

void check_marginal(const NonlinearModel& model,
                    Integration integration,
                    const MarginalOptions& options) {
  const ModelSpecification& specification = model.specification();
  if (specification.random.empty()) {
    throw UsageError(
        "a marginal likelihood needs random effects; for a model without random effects use ols or "
        "gnls");
  }
  if (integration != Integration::kQuadrature) return;
  constexpr std::size_t kMostQuadrature = 3;
  const std::size_t effects = specification.random.back().coefficients.size();
  if (specification.random.size() > 1 || effects > kMostQuadrature) {
    throw UsageError(fmt::format(
        "quadrature (agq) supports at most {} random effects of one grouping; use laplace",
        kMostQuadrature));
  }
  constexpr int kMostPoints = 100;
  if (options.quadrature_points < 1 || options.quadrature_points > kMostPoints) {
    throw UsageError(fmt::format("quadrature needs 1 to {} points per random effect", kMostPoints));
  }
  constexpr double kMostNodes = 20000.0;
  const double nodes = std::pow(options.quadrature_points, static_cast<double>(effects));
  if (nodes > kMostNodes) {
    throw UsageError(
        fmt::format("{} points per random effect make {:.0f} points for {} random effects; the "
                    "limit is {:.0f}, {} per random effect",
                    options.quadrature_points,
                    nodes,
                    effects,
                    kMostNodes,
                    std::floor(std::pow(kMostNodes, 1.0 / static_cast<double>(effects)))));
  }
}

std::optional<MixedEffectsFit> refit_marginal(const NonlinearModel& model,
                                              const MixedEffectsFit& start,
                                              Integration integration,
                                              const MarginalOptions& options) {
  check_marginal(model, integration, options);
  std::optional<MixedEffectsFit> fit = marginal_from(model, start, integration, options);
  if (!fit || !fit->convergence.converged()) return std::nullopt;
  describe(model, *fit);
  judge(model, *fit, Rounds::kEvaluations);
  return fit;
}

std::optional<MixedEffectsFit> marginal_from(const NonlinearModel& model,
                                             const MixedEffectsFit& start,
                                             Integration integration,
                                             const MarginalOptions& options,
                                             const MarginalEffort& effort,
                                             Obstacle* obstacle) {
  MarginalSearch search(model, integration, options, start);
  if (!effort.is_complete) search.limit_search();
  search.race(effort.known);
  search.try_fit(start);
  if (!search.has_optimum()) return std::nullopt;
  if (obstacle != nullptr) *obstacle = search.obstacle();
  return result_of(search, model, integration, options, effort.is_complete);
}

double marginal_log_likelihood(const NonlinearModel& model,
                               const MixedEffectsFit& fit,
                               Integration integration,
                               const MarginalOptions& options) {
  return MarginalSearch(model, integration, options, fit).value_of(fit);
}

MixedEffectsFit fit_marginal(const NonlinearModel& model,
                             const VectorXd& start,
                             Integration integration,
                             const MarginalOptions& options) {
  check_marginal(model, integration, options);
  const MixedEffectsFit linearized = fit_lindstrom_bates(model, start, {.starts = options.starts});
  return fit_marginal_from(model, start, linearized, integration, options);
}

MixedEffectsFit fit_marginal_from(const NonlinearModel& model,
                                  const VectorXd& pooled,
                                  const MixedEffectsFit& linearized,
                                  Integration integration,
                                  const MarginalOptions& options) {
  MarginalSearch search(model, integration, options, linearized);
  const bool is_first_order = !needs_curvature(integration);
  // With parameters that are not identifiable, the linear model is nevertheless at a maximum.
  const bool is_at_maximum =
      linearized.convergence.converged() || linearized.convergence.rank < pooled.size();
  if (is_at_maximum || is_first_order) search.try_fit(linearized);
  std::optional<MixedEffectsFit> smooth;
  if (!search.has_converged() && !is_first_order) {
    // The first-order likelihood is smooth wherever there are modes, and bounded.
    MarginalSearch first_order(model, Integration::kInteraction, options, linearized);
    first_order.try_fit(linearized);
    if (!first_order.has_converged()) first_order.try_pooled(pooled);
    if (first_order.has_optimum()) smooth = first_order.result();
    if (smooth) search.try_fit(*smooth);
  }
  if (!search.has_converged()) search.try_pooled(pooled);
  if (!search.has_optimum()) {
    return smooth ? without_clear_modes(model, *std::move(smooth))
                  : without_modes(model, linearized);
  }
  MixedEffectsFit fit = result_of(search, model, integration, options, true);
  describe(model, fit);
  judge(model, fit, Rounds::kEvaluations, false, search.obstacle());
  return fit;
}

}  // namespace silvafit::fit
