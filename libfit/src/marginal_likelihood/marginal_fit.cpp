// SPDX-License-Identifier: MIT
// Maximum marginal likelihood: starts, and the result if there is no maximum.
#include "marginal_likelihood/marginal_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "marginal_likelihood/marginal_search.hpp"
#include "mixed_effects/degenerate_fit.hpp"
#include "optimization/tolerances.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "verdict/reducible.hpp"

namespace silvafit::fit {
namespace {

/// The result, in units of the end of the search: if the start was far away, finite differences in
/// its units do not measure the curvature at the end.
MixedEffectsFit result_of(MarginalSearch& search,
                          const NonlinearModel& model,
                          Method method,
                          const MixedEffectsOptions& options,
                          bool is_complete) {
  MixedEffectsFit fit = search.result();
  if (!search.is_out_of_scale(fit)) return fit;
  MarginalSearch anew(model, method, options, fit.estimate);
  if (!is_complete) anew.limit_search();
  anew.try_fit(fit);
  if (!anew.has_optimum()) return fit;
  MixedEffectsFit again = anew.result();
  const bool is_as_good = again.log_likelihood > fit.log_likelihood - kRoundedLikelihood;
  return is_as_good && (anew.has_converged() || !search.has_converged()) ? again : fit;
}

MarginalEnd end_of(MarginalSearch& search,
                   const NonlinearModel& model,
                   Method method,
                   const MixedEffectsOptions& options,
                   bool is_complete) {
  MarginalEnd end{.evaluations = search.evaluations()};
  if (!search.has_optimum()) return end;
  end.obstacle = search.obstacle();
  end.fit = result_of(search, model, method, options, is_complete);
  return end;
}

/// The result if the likelihood with curvature has no valid point near that without it.
MixedEffectsFit without_clear_modes(const NonlinearModel& model, MixedEffectsFit fit) {
  describe(model, fit);
  judge(model, fit, Rounds::kEvaluations);
  if (has_no_maximum(model, fit)) return fit;
  fit.convergence.conclude(
      ConvergenceStatus::kInvalidApproximation,
      {.kind = Finding::Kind::kInvalidAtFirstOrder, .reducible = reducible(model.specification())});
  return fit;
}

MixedEffectsFit without_modes(const NonlinearModel& model, MixedEffectsFit linearized) {
  // The message of the linear model's search is more informative about a failed start.
  if (std::isnan(linearized.sigma) || has_no_maximum(model, linearized)) return linearized;
  linearized.convergence.conclude(
      ConvergenceStatus::kInvalidApproximation,
      {.kind = Finding::Kind::kNoModes, .reducible = reducible(model.specification())});
  return linearized;
}

}  // namespace

void check_marginal(const NonlinearModel& model,
                    Method method,
                    const MixedEffectsOptions& options) {
  const ModelSpecification& specification = model.specification();
  if (specification.random.empty()) {
    throw UsageError(
        "a marginal likelihood needs random effects; for a model without random effects use ols or "
        "gnls");
  }
  if (method != Method::kQuadrature) return;
  constexpr std::size_t kMostQuadrature = 3;
  const std::size_t effects = specification.random.back().coefficients.size();
  if (specification.random.size() > 1 || are_crossed(specification.random) ||
      effects > kMostQuadrature) {
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
                                              Method method,
                                              const MixedEffectsOptions& options) {
  check_marginal(model, method, options);
  std::optional<MixedEffectsFit> fit = marginal_from(model, start, method, options).fit;
  if (!fit || !fit->convergence.converged()) return std::nullopt;
  describe(model, *fit);
  compute_errors(model, method, options, *fit);
  judge(model, *fit, Rounds::kEvaluations);
  return fit;
}

void compute_errors(const NonlinearModel& model,
                    Method method,
                    const MixedEffectsOptions& options,
                    MixedEffectsFit& fit) {
  const bool is_at_kink = std::ranges::any_of(fit.convergence.evidence, [](const Evidence& item) {
    return item.kind == Evidence::Kind::kKink;
  });
  if (!fit.convergence.converged() || is_at_kink) return;
  MarginalSearch(model, method, options, fit.estimate).compute_errors(fit);
}

MarginalEnd marginal_from(const NonlinearModel& model,
                          const MixedEffectsFit& start,
                          Method method,
                          const MixedEffectsOptions& options,
                          const MarginalEffort& effort) {
  MarginalSearch search(model, method, options, start.estimate);
  if (!effort.is_complete) search.limit_search();
  search.stop_below(effort.known);
  search.try_fit(start);
  return end_of(search, model, method, options, effort.is_complete);
}

MarginalEnd marginal_from_coefficients(const NonlinearModel& model,
                                       const VectorXd& coefficients,
                                       Method method,
                                       const MixedEffectsOptions& options,
                                       const MarginalEffort& effort) {
  MarginalSearch search(model, method, options, coefficients);
  search.limit_search();
  search.stop_below(effort.known);
  search.try_pooled(coefficients);
  return end_of(search, model, method, options, false);
}

double marginal_log_likelihood(const NonlinearModel& model,
                               const MixedEffectsFit& fit,
                               Method method,
                               const MixedEffectsOptions& options) {
  return MarginalSearch(model, method, options, fit.estimate).value_of(fit);
}

MixedEffectsFit fit_marginal(const NonlinearModel& model,
                             const VectorXd& start,
                             Method method,
                             const MixedEffectsOptions& options) {
  check_marginal(model, method, options);
  const MixedEffectsFit linearized = fit_lindstrom_bates(model, start, {.starts = options.starts});
  return fit_marginal_from(model, start, linearized, method, options);
}

MixedEffectsFit fit_marginal_from(const NonlinearModel& model,
                                  const VectorXd& pooled,
                                  const MixedEffectsFit& linearized,
                                  Method method,
                                  const MixedEffectsOptions& options) {
  MarginalSearch search(model, method, options, linearized.estimate);
  const bool is_first_order = !needs_curvature(method);
  // With parameters that are not identifiable, the linear model may still be at a maximum.
  const bool is_at_maximum = linearized.convergence.converged() ||
                             linearized.convergence.rank < pooled.size() ||
                             has_unbounded_range(model, linearized);
  if (is_at_maximum || is_first_order) search.try_fit(linearized);
  std::optional<MixedEffectsFit> smooth;
  if (!search.has_converged() && !is_first_order) {
    // The first-order likelihood is bounded, and smooth if there are modes.
    MarginalSearch first_order(model, Method::kInteraction, options, linearized.estimate);
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
  MixedEffectsFit fit = result_of(search, model, method, options, true);
  describe(model, fit);
  compute_errors(model, method, options, fit);
  judge(model, fit, Rounds::kEvaluations, false, search.obstacle());
  return fit;
}

}  // namespace silvafit::fit
