// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <utility>

#include "correlation/correlation_structure.hpp"
#include "fit_model/constrained_fit.hpp"
#include "fit_model/doubts.hpp"
#include "fit_model/far_columns.hpp"
#include "fit_model/limit_of_curve.hpp"
#include "least_squares/exchanged_minima.hpp"
#include "least_squares/start_search.hpp"
#include "likelihood/effect_posteriors.hpp"
#include "lindstrom_bates/lindstrom_bates_search.hpp"
#include "marginal_likelihood/marginal_fit.hpp"
#include "mixed_effects/mixed_effects_evidence.hpp"
#include "model/held_coefficients.hpp"
#include "model/response_fingerprint.hpp"
#include "optimization/tolerances.hpp"
#include "optimum_search/chosen_optimum.hpp"
#include "optimum_search/optimum_search.hpp"
#include "result/earlier_fit.hpp"
#include "result/group_coefficients.hpp"
#include "result/variance_shares.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

/// Restricted likelihood without random effects is that of gnls.
Method method_of(const ModelSpecification& specification, const FitModelOptions& options) {
  if (options.method) return *options.method;
  const Method method = default_method(specification);
  return options.reml && method == Method::kOrdinary ? Method::kGeneralized : method;
}

void check_method(const ModelSpecification& specification, Method method, bool reml) {
  if (!specification.random.empty() && !is_mixed(method)) {
    throw UsageError(fmt::format("the method {} does not fit random effects; use lb or laplace",
                                 word_of(method)));
  }
  if (specification.random.empty() && is_mixed(method)) {
    throw UsageError(fmt::format(
        "the method {} needs random effects; for a model without random effects use ols or gnls",
        word_of(method)));
  }
  if (reml && method != Method::kLindstromBates && method != Method::kGeneralized) {
    throw UsageError(fmt::format(
        "restricted maximum likelihood (REML) is available for lb and gnls only, not for {}",
        word_of(method)));
  }
  if (method == Method::kOrdinary && !specification.variance.is_constant()) {
    throw UsageError("the method ols does not fit a variance function; use gnls");
  }
  if (method == Method::kOrdinary && specification.correlation) {
    throw UsageError("the method ols has independent residuals; for a `correlation` use gnls");
  }
}

void check_start(const ModelSpecification& specification,
                 const std::map<std::string, double>& start) {
  for (const auto& [name, value] : start) {
    check_known(specification, name);
    if (!std::isfinite(value))
      throw UsageError(fmt::format("the start value of {} is not a number", name));
  }
}

/// Checks that each term has several groups, and a crossed one fewer random effects than there are
/// rows.
/// \throws InputError that names the term, its groups and the rows
void check_groups(const NonlinearModel& model) {
  for (std::size_t t = 0; t < model.term_count(); ++t) {
    const RandomEffects& term = model.specification().random[t];
    const Index groups = model.group_count(t);
    const Index effects = groups * std::ssize(term.coefficients);
    const std::string of = fmt::format("`{} | {}`", term.text(), term.group_text());
    const Place place{.file = model.place(0).file, .column = term.group};
    if (groups < 2) {
      throw InputError(
          fmt::format("{}: all {} rows are in the group '{}', so that the variance between groups "
                      "cannot be estimated; remove the term",
                      of,
                      model.observations(),
                      model.group_labels(t).front()),
          place);
    }
    if (model.crossed() != nullptr && effects >= model.observations()) {
      throw InputError(
          fmt::format("{}: {} groups have {} random effects, as many as the {} rows or more, so "
                      "that effects and residuals cannot be distinguished; remove effects, or use "
                      "coarser groups",
                      of,
                      groups,
                      effects,
                      model.observations()),
          place);
    }
  }
}

/// Checks that no row has the residual variance 0 or infinity by a column of the variance function:
/// it would be fitted exactly, or not count.
/// \throws InputError that names the column, the line and the value
void check_variance_columns(const NonlinearModel& model) {
  for (const VarianceFactor& factor : model.specification().variance.factors) {
    if (factor.column.empty() || kind_of(factor).allows_zero(factor)) continue;
    const VectorXd values = model.column(factor.column);
    const auto zero = std::ranges::find(values, 0.0);
    if (zero == values.end()) continue;
    Place place = model.place(static_cast<Index>(zero - values.begin()));
    place.column = factor.column;
    throw InputError(
        fmt::format("the value is 0, so that the residual of this row has the variance 0 or "
                    "infinity by the variance function {}; exclude such rows with `where`, correct "
                    "the value, or use constant-plus-power",
                    factor.text()),
        place);
  }
}

std::vector<ColumnRange> ranges_of(const NonlinearModel& model) {
  std::vector<ColumnRange> ranges;
  for (const std::string& name : model.specification().predictors()) {
    data::TextMatch match;
    if (data::is_text_match(name, match)) continue;
    const VectorXd values = model.column(name);
    ranges.push_back({.column = name, .low = values.minCoeff(), .high = values.maxCoeff()});
  }
  return ranges;
}

FitResult described(const NonlinearModel& model, Method method, const FitModelOptions& options) {
  check_groups(model);
  check_variance_columns(model);
  FitResult result{.fit = FittedModel(model.specification())};
  FittedModel& fit = result.fit;
  fit.method = method;
  fit.reml = options.reml;
  if (method == Method::kQuadrature) fit.quadrature_points = options.quadrature_points;
  fit.observations = model.observations();
  fit.excluded = static_cast<Index>(model.excluded());
  fit.response_fingerprint = response_fingerprint(model.response());
  fit.ranges = ranges_of(model);
  for (const auto& [column, labels] : model.levels()) {
    fit.levels.push_back({.column = column, .labels = {labels.begin(), labels.end()}});
  }
  name_terms(model, fit);
  fit.set_missing(model.specification());
  result.rows = model.rows();
  return result;
}

/// Replaces missing estimates by those that were found; a method may leave some missing.
void take_estimates(FittedModel& fit, Estimates& found) {
  if (found.random.empty()) found.random = std::move(fit.random);
  if (found.variance.factors.empty() && !found.variance.correlation)
    found.variance = std::move(fit.variance);
  static_cast<Estimates&>(fit) = std::move(found);
}

void take_over(FitResult& result, LeastSquaresFit&& found) {
  // With fewer observations than coefficients there are no degrees of freedom.
  const double freedom = found.residual_degrees_of_freedom();
  found.degrees_of_freedom.setConstant(found.estimate.size(), freedom < 0.0 ? kNaN : freedom);
  take_estimates(result.fit, found);
  result.residual_sd = VectorXd::Constant(result.fit.observations, result.fit.sigma);
  result.fitted_population = std::move(found.fitted);
  result.fitted_conditional = result.fitted_population;
}

void take_over(FitResult& result, MixedEffectsFit&& found) {
  take_estimates(result.fit, found);
  result.fitted_population = std::move(found.fitted_population);
  result.fitted_conditional = std::move(found.fitted_conditional);
  result.residual_sd = std::move(found.residual_sd);
}

/// The result of a mixed or generalized fit without start values.
void report_failed_start(FitResult& result, LeastSquaresFit&& least_squares) {
  const Convergence reason = std::move(least_squares.convergence);
  take_over(result, std::move(least_squares));
  FittedModel& fit = result.fit;
  fit.covariance.setConstant(kNaN);
  fit.sigma = fit.log_likelihood = kNaN;
  fit.parameter_count = 0;
  fit.variance = VarianceEstimate::missing(fit.specification.variance);
  fit.convergence = {
      .status = reason.status, .findings = reason.findings, .evidence = reason.evidence};
  fit.convergence.find({.kind = Finding::Kind::kStartFailed});
}

void compute_statistics(FitResult& result, const NonlinearModel& model) {
  FittedModel& fit = result.fit;
  fit.population = fit_statistics(model.response(), result.fitted_population);
  fit.conditional = fit_statistics(model.response(), result.fitted_conditional);
  if (!fit.has_random_effects()) return;
  const VarianceShares shares = variance_shares(fit, model, result.residual_sd);
  fit.r2_marginal = shares.marginal;
  fit.r2_conditional = shares.conditional;
}

MixedEffectsOptions mixed_options(const NonlinearModel& model, const FitModelOptions& options) {
  return {.starts = complete_starts(model, options.start),
          .maximum_iterations = options.maximum_iterations,
          .reml = options.reml,
          .is_brief = options.effort == SearchEffort::kBrief,
          .quadrature_points = options.quadrature_points,
          .trace = options.trace};
}

MixedEffectsFit fit_mixed(const NonlinearModel& model,
                          const LeastSquaresFit& pooled,
                          Method method,
                          const FitModelOptions& options);

/// The better of two ends. If the range of the other one's correlation is without bound and its
/// likelihood is higher, a doubt says so.
MixedEffectsFit better_of(const NonlinearModel& model, MixedEffectsFit fit, MixedEffectsFit other) {
  const auto is_limit = [&](const MixedEffectsFit& end) {
    return !end.convergence.converged() &&
           (has_unbounded_range(model, end) || has_unbounded_power(model, end));
  };
  const auto is_end = [&](const MixedEffectsFit& end) {
    return end.convergence.converged() || is_limit(end);
  };
  const auto value = [&](const MixedEffectsFit& end) {
    return compared(end.log_likelihood, is_limit(end));
  };
  const bool is_better =
      is_end(fit) == is_end(other) ? value(other) > value(fit) + kHigher : is_end(other);
  if (is_better) std::swap(fit, other);
  if (has_unbounded_range(model, other)) note_unbounded_range(other.log_likelihood, fit);
  for (const Finding& finding : other.convergence.findings) {
    if (finding.kind == Finding::Kind::kRangeDoubt) note_unbounded_range(finding.values[0], fit);
  }
  return fit;
}

/// With correlated residuals: from the pooled fit, for a marginal likelihood by lb first, and from
/// the optimum with independent residuals.
MixedEffectsFit fit_correlated(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               Method method,
                               const FitModelOptions& options) {
  const MixedEffectsOptions search = mixed_options(model, options);
  const bool by_likelihood = is_marginal(method);
  if (by_likelihood) check_marginal(model, method, search);
  MixedEffectsFit fit =
      by_likelihood
          ? fit_marginal_from(model,
                              pooled.estimate,
                              fit_correlated(model, pooled, Method::kLindstromBates, options),
                              method,
                              search)
          : fit_lindstrom_bates(model, pooled.estimate, search);
  if (model.specification().random.empty() || options.effort == SearchEffort::kBrief) return fit;
  const MixedEffectsFit independent =
      fit_mixed(model.with_independent_residuals(), pooled, method, options);
  if (!independent.convergence.converged()) return fit;
  std::optional<MixedEffectsFit> other = by_likelihood
                                             ? refit_marginal(model, independent, method, search)
                                             : refit_lindstrom_bates(model, independent, search);
  return other ? better_of(model, std::move(fit), *std::move(other)) : fit;
}

/// The fit with the roles of coefficients that the start values or bounds say.
MixedEffectsFit in_wished_roles(const NonlinearModel& model,
                                const MixedEffectsFit& fit,
                                Method method,
                                const FitModelOptions& options) {
  MixedEffectsFit result =
      with_wished_roles(model, fit, method, mixed_options(model, options), options);
  if (result.estimate == fit.estimate) return fit;
  describe(model, result);
  judge(model,
        result,
        is_marginal(method) ? Rounds::kEvaluations : Rounds::kAlternations,
        options.reml);
  return result;
}

MixedEffectsFit fit_mixed(const NonlinearModel& model,
                          const LeastSquaresFit& pooled,
                          Method method,
                          const FitModelOptions& options) {
  if (model.specification().correlation) {
    return in_wished_roles(model, fit_correlated(model, pooled, method, options), method, options);
  }
  if (options.effort == SearchEffort::kThorough) {
    return search_optimum(model, pooled, method, mixed_options(model, options), options);
  }
  if (is_marginal(method)) {
    return fit_marginal(model, pooled.estimate, method, mixed_options(model, options));
  }
  return fit_lindstrom_bates(model, pooled.estimate, mixed_options(model, options));
}

/// The start, and if its correlation is at an end of its range, which has no slope there, also
/// with correlations inside.
std::vector<MixedEffectsFit> with_inner_correlations(const MixedEffectsFit& start,
                                                     const FittedModel& earlier) {
  std::vector<MixedEffectsFit> result{start};
  if (!start.variance.correlation || !earlier.convergence.has_boundary()) return result;
  const CorrelationStructure structure(*start.variance.correlation);
  for (const VectorXd& inner : structure.starts()) {
    result.push_back(start);
    result.back().variance.correlation->values = structure.natural(inner);
  }
  return result;
}

/// The fit that starts from an earlier one; no value if there is none, or it does not converge.
std::optional<MixedEffectsFit> fit_from_earlier(const NonlinearModel& model,
                                                Method method,
                                                const FitModelOptions& options) {
  if (options.from == nullptr || method == Method::kOrdinary) return std::nullopt;
  const std::optional<MixedEffectsFit> start = as_start(*options.from, model);
  if (!start) return std::nullopt;
  std::optional<MixedEffectsFit> best;
  for (const MixedEffectsFit& from : with_inner_correlations(*start, *options.from)) {
    std::optional<MixedEffectsFit> fit =
        is_marginal(method) ? refit_marginal(model, from, method, mixed_options(model, options))
                            : refit_lindstrom_bates(model, from, mixed_options(model, options));
    if (fit && (!best || fit->log_likelihood > best->log_likelihood)) best = std::move(fit);
  }
  return best;
}

/// Start values by coefficient of the whole model; held coefficients need none. Values that the
/// options do not give come from an earlier fit by least squares.
std::map<std::string, double> starts_of(const NonlinearModel& model,
                                        Method method,
                                        const FitModelOptions& options) {
  const FittedModel* const earlier = method == Method::kOrdinary ? options.from : nullptr;
  std::map<std::string, double> result;
  for (const std::string& name : model.coefficient_names()) {
    if (const auto found = options.start.find(name); found != options.start.end()) {
      result.insert(*found);
    } else if (earlier != nullptr && earlier->convergence.converged()) {
      const auto& known = earlier->coefficient_names;
      const auto place = std::ranges::find(known, name) - known.begin();
      if (place == std::ssize(known)) continue;
      const double value = earlier->estimate[place];
      if (std::isfinite(value)) result.emplace(name, value);
    }
  }
  return result;
}

FitResult with_statistics(FitResult result, const NonlinearModel& model) {
  compute_statistics(result, model);
  keep_uncertainty(model, result.fit);
  return result;
}

/// The least-squares fit. In a thorough search, start values of all coefficients are not used here,
/// but added to the starts that are found without them.
LeastSquaresFit pooled_fit_of(const NonlinearModel& model,
                              Method method,
                              const FitModelOptions& options,
                              bool is_thorough) {
  LeastSquaresOptions least_squares{
      .rule = options.rule, .other_minima = is_thorough, .further_starts = options.spread_starts};
  const bool has_start = !complete_starts(model, options.start).empty();
  if (is_thorough && has_start) {
    LeastSquaresFit fit = fit_least_squares(model, least_squares);
    if (fit.estimate.allFinite()) return fit;
  }
  least_squares.start = starts_of(model, method, options);
  return fit_least_squares(model, least_squares);
}

FitResult fit_freely(const NonlinearModel& model, Method method, const FitModelOptions& options) {
  FitResult result = described(model, method, options);
  if (auto found = fit_from_earlier(model, method, options)) {
    take_over(result, *std::move(found));
    return with_statistics(std::move(result), model);
  }
  const bool is_thorough = method != Method::kOrdinary && options.effort == SearchEffort::kThorough;
  LeastSquaresFit least_squares = pooled_fit_of(model, method, options, is_thorough);
  if (method == Method::kOrdinary) {
    take_over(result, std::move(least_squares));
  } else if (least_squares.estimate.allFinite()) {
    take_over(result, fit_mixed(model, least_squares, method, options));
  } else {
    report_failed_start(result, std::move(least_squares));
  }
  return with_statistics(std::move(result), model);
}

/// From a fit nearby, without a search for starts, which may end far away.
FitResult fit_nearby(const NonlinearModel& model,
                     Method method,
                     FitModelOptions options,
                     const FittedModel& nearby) {
  options.from = &nearby;
  options.start.clear();
  if (method == Method::kOrdinary) return fit_freely(model, method, options);
  FitResult result = described(model, method, options);
  if (auto found = fit_from_earlier(model, method, options)) {
    take_over(result, *std::move(found));
    return with_statistics(std::move(result), model);
  }
  result.fit.convergence.conclude(ConvergenceStatus::kMaximumNotReached,
                                  {.kind = Finding::Kind::kNoneFromStart});
  return result;
}

/// The coefficients of a model that holds some of them, from those of the whole one; none if one is
/// missing.
VectorXd of_model(const NonlinearModel& model,
                  const std::vector<std::string>& names,
                  const VectorXd& all) {
  VectorXd result(model.coefficient_count());
  for (Index j = 0; j < result.size(); ++j) {
    const auto found =
        std::ranges::find(names, model.coefficient_names()[static_cast<std::size_t>(j)]);
    if (found == names.end() || found - names.begin() >= all.size()) return {};
    result[j] = all[found - names.begin()];
  }
  return result;
}

/// The best known optimum within the bounds: of the fit outside of them, of pooled least squares if
/// nothing is held, or one of the same mean with exchanged coefficients.
std::optional<VectorXd> known_point_inside(const NonlinearModel& model,
                                           const FittedModel& outside,
                                           bool is_free,
                                           const std::map<std::string, Bounds>& bounds) {
  std::vector<VectorXd> points;
  for (const LocalOptimum& optimum : outside.optima) points.push_back(optimum.estimate);
  points.push_back(outside.estimate);
  for (VectorXd& point : points) point = of_model(model, outside.coefficient_names, point);
  if (is_free) {
    LeastSquaresFit pooled = fit_least_squares(model, {.other_minima = true});
    points.push_back(std::move(pooled.estimate));
    std::ranges::move(pooled.other_minima, std::back_inserter(points));
  }
  for (const VectorXd& point : points) {
    if (point.size() != model.coefficient_count() || !point.allFinite()) continue;
    if (is_inside(model.coefficient_names(), point, bounds)) return point;
    for (const VectorXd& other : points_of_same_mean(model, point)) {
      if (is_inside(model.coefficient_names(), other, bounds)) return other;
    }
  }
  return std::nullopt;
}

/// The best fit within the bounds from a known optimum there, if any.
std::optional<FitResult> fit_inside(const NonlinearModel& model,
                                    Method method,
                                    const FitModelOptions& options,
                                    const FittedModel& outside,
                                    bool is_free) {
  const auto start = known_point_inside(model, outside, is_free, options.bounds);
  if (!start) return std::nullopt;
  FitModelOptions from_there = options;
  from_there.start.clear();
  for (Index j = 0; j < start->size(); ++j) {
    from_there.start[model.coefficient_names()[static_cast<std::size_t>(j)]] = (*start)[j];
  }
  return fit_freely(model, method, from_there);
}

/// Whether another method may find a result: the data are not the cause.
bool may_depend_on_method(const Convergence& convergence) {
  switch (convergence.status) {
    case ConvergenceStatus::kContainedModelHigher:
    case ConvergenceStatus::kInvalidApproximation:
    case ConvergenceStatus::kDiverged:
    case ConvergenceStatus::kIterationLimit:
    case ConvergenceStatus::kMaximumNotReached:
      return true;
    default:
      return false;
  }
}

FitResult fit_by(const ModelSpecification& specification,
                 const data::Table& table,
                 const FitModelOptions& options,
                 Method method) {
  FitModelOptions without_bounds = options;
  without_bounds.bounds.clear();
  const FreeFit fit = [&](const ModelSpecification& model, const FittedModel* nearby) {
    const NonlinearModel bound(model, table, options.threads, options.stop);
    return nearby == nullptr ? fit_freely(bound, method, without_bounds)
                             : fit_nearby(bound, method, without_bounds, *nearby);
  };
  const InsideFit inside = [&](const FittedModel& outside, const HeldValues& held) {
    const ModelSpecification model = with_held(specification, held);
    const NonlinearModel bound(model, table, options.threads, options.stop);
    return fit_inside(bound, method, options, outside, held.size() == options.fixed.size());
  };
  const auto mark_limit_of = [&](const ModelSpecification& fitted, FitResult& found) {
    const NonlinearModel model(fitted, table, options.threads, options.stop);
    mark_limit(model, held_fit_of(fitted, {}, fit), found, options.bounds);
  };
  const bool finds_limits = method != Method::kOrdinary;
  // With bounds the result is tested, not each fit on the way to it.
  const bool can_have_limit = finds_limits && options.bounds.empty();
  const FreeFit whole_fit = [&](const ModelSpecification& fitted, const FittedModel* nearby) {
    FitResult found = fit(fitted, nearby);
    if (can_have_limit) mark_limit_of(fitted, found);
    return found;
  };
  const bool is_free = options.fixed.empty() && options.bounds.empty();
  FitResult result = is_free ? whole_fit(specification, nullptr)
                             : fit_constrained(specification, table, options, whole_fit, inside);
  const bool has_bound = std::ranges::any_of(options.bounds, [&](const auto& bound) {
    return result.fit.convergence.has(Evidence::Kind::kLowerBound, bound.first) ||
           result.fit.convergence.has(Evidence::Kind::kUpperBound, bound.first);
  });
  if (finds_limits && !can_have_limit && !has_bound && options.fixed.empty() &&
      result.fit.convergence.converged()) {
    mark_limit_of(specification, result);
  }
  const NonlinearModel model(specification, table, options.threads, options.stop);
  if (auto start = start_beyond_infinity(model, result.fit); is_free && !start.empty()) {
    FitModelOptions beyond = options;
    beyond.start = std::move(start);
    FitResult other = fit_freely(model, method, beyond);
    if (can_have_limit) mark_limit_of(specification, other);
    const bool is_higher = other.fit.log_likelihood > result.fit.log_likelihood;
    if (other.fit.convergence.converged() && is_higher) result = std::move(other);
  }
  note_far_columns(model, result.fit);
  // The stored uncertainty is that of the coefficients that were free.
  if (!is_free) keep_uncertainty(model, result.fit);
  return result;
}

}  // namespace

FitResult fit_model(const ModelSpecification& specification,
                    const data::Table& table,
                    const FitModelOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const Method method = method_of(specification, options);
  check_method(specification, method, options.reml);
  check_start(specification, options.start);
  FitResult result = fit_by(specification, table, options, method);
  // focei has a likelihood that is bounded and smooth, and finds a result for nearly all data.
  if (!options.method && !options.reml && is_mixed(method) &&
      may_depend_on_method(result.fit.convergence)) {
    FitResult other = fit_by(specification, table, options, Method::kInteraction);
    if (other.fit.convergence.converged()) {
      result = std::move(other);
      result.fit.convergence.find({.kind = Finding::Kind::kFallback, .names = {word_of(method)}});
    }
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  result.fit.seconds = elapsed.count();
  add_doubts(table, options, result);
  return result;
}

}  // namespace silvafit::fit
