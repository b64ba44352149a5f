// SPDX-License-Identifier: MIT
#include "silvafit/fit/intervals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "inference/comparable_likelihoods.hpp"
#include "inference/information.hpp"
#include "inference/profile_search.hpp"
#include "least_squares/start_search.hpp"
#include "model/held_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double normal_quantile(double level) {
  return boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * level);
}

/// NaN without degrees of freedom.
double t_quantile(double level, double freedom) {
  if (!(freedom > 0.0)) return kNaN;
  return boost::math::quantile(boost::math::students_t(freedom), 0.5 + 0.5 * level);
}

/// Of least squares: n - p with p estimated coefficients. Those that are held have no degrees of
/// freedom.
double residual_freedom(const SurfaceSetting& setting) {
  return static_cast<double>(setting.fit.observations - setting.estimate.size());
}

/// By the fit's own standard errors and degrees of freedom; coefficients that are held have none.
void add_wald_coefficients(const FittedModel& fit, double level, Intervals& result) {
  const VectorXd errors = fit.standard_errors();
  for (Index j = 0; j < fit.estimate.size(); ++j) {
    if (std::isnan(errors[j])) continue;
    const double reach = t_quantile(level, fit.degrees_of_freedom[j]) * errors[j];
    ParameterInterval interval{.name = fit.coefficient_names[static_cast<std::size_t>(j)],
                               .estimate = fit.estimate[j],
                               .lower = fit.estimate[j] - reach,
                               .upper = fit.estimate[j] + reach};
    if (std::isnan(reach)) interval.note = "unknown: no degrees of freedom";
    result.parameters.push_back(std::move(interval));
  }
}

/// Of derived quantities, by the delta method.
void add_wald_derived(const FittedModel& fit, double level, Intervals& result) {
  const std::vector<DerivedValue> values = derived_values(fit);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto& [estimate, error, freedom] = values[k];
    const double reach = t_quantile(level, freedom) * error;
    result.parameters.push_back({.kind = ParameterKind::kDerived,
                                 .name = fit.specification.derived[k].name,
                                 .estimate = estimate,
                                 .lower = estimate - reach,
                                 .upper = estimate + reach});
  }
}

void add_wald_others(const FittedModel& fit, const data::Table& table, Intervals& result) {
  const SurfaceSetting setting(fit, table);
  const auto surface = make_surface(setting);
  const std::vector<NaturalParameter> parameters = natural_parameters(setting, surface->layout());
  const ProfileStart start = start_of(setting, *surface);
  const MatrixXd covariance = symmetric_covariance(setting, *surface, parameters, start);
  const std::vector<std::string> confounded = confounded_variances(setting).names;
  const double quantile = normal_quantile(result.level);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const NaturalParameter& parameter = parameters[k];
    if (parameter.kind == ParameterKind::kFixed) continue;
    const double estimate =
        parameter.value(surface->layout(), setting.variance, surface->optimum());
    const double middle = to_symmetric(parameter, estimate);
    double error = std::sqrt(covariance(static_cast<Index>(k), static_cast<Index>(k)));
    // Directions without curvature are not part of the inverse.
    if (!(error > 0.0)) error = kNaN;
    ParameterInterval interval{.kind = parameter.kind,
                               .name = parameter.name,
                               .estimate = estimate,
                               .lower = from_symmetric(parameter, middle - quantile * error),
                               .upper = from_symmetric(parameter, middle + quantile * error)};
    if (std::isnan(interval.lower)) {
      const bool is_confounded = std::ranges::find(confounded, interval.name) != confounded.end();
      interval.note =
          is_confounded
              ? fmt::format("unknown; not identifiable: {}", fmt::join(confounded, ", "))
              : "boundary estimate: a standard error has no meaning there; use profile intervals";
    }
    result.parameters.push_back(std::move(interval));
  }
}

/// The decrease of twice the log-likelihood at the limits of a parameter's interval.
ProfileCut cut_of(const SurfaceSetting& setting, ParameterKind kind, double level) {
  // By the 50:50 mixture of 0 and chi-squared(1): its tail of 1 - level is that of 2(1 - level).
  const double one_sided = std::max(0.0, 2.0 * level - 1.0);
  ProfileCut cut{.both_sides = std::pow(normal_quantile(level), 2),
                 .one_side = std::pow(normal_quantile(one_sided), 2)};
  const bool is_fixed = kind == ParameterKind::kFixed || kind == ParameterKind::kDerived;
  if (setting.fit.method == Method::kOrdinary && is_fixed) {
    const auto n = static_cast<double>(setting.fit.observations);
    const double freedom = residual_freedom(setting);
    const double t = t_quantile(level, freedom);
    cut.both_sides = n * std::log1p(t * t / freedom);
  }
  return cut;
}

/// Of least squares: the limits c at which (n - p)(2 log(c/s) + s^2/c^2 - 1), the decrease of twice
/// the log-likelihood of the residual contrasts, is the quantile.
ParameterInterval least_squares_sigma(const FittedModel& fit, double freedom, double level) {
  const double quantile = std::pow(normal_quantile(level), 2) / freedom;
  const auto excess = [quantile](double t) {  // t = log(c/s)
    return 2.0 * t + std::exp(-2.0 * t) - 1.0 - quantile;
  };
  const auto root = [&](double near, double far) {
    while (excess(far) < 0.0) far *= 2.0;
    std::uintmax_t trials = 200;
    const boost::math::tools::eps_tolerance<double> tolerance(50);
    const auto [low, high] = boost::math::tools::toms748_solve(
        excess, std::min(near, far), std::max(near, far), tolerance, trials);
    return fit.sigma * std::exp(0.5 * (low + high));
  };
  return {.kind = ParameterKind::kSigma,
          .name = "sigma",
          .estimate = fit.sigma,
          .lower = root(0.0, -1.0),
          .upper = root(0.0, 1.0)};
}

/// By pooled least squares: random effects are deviations from its coefficients. A likelihood that
/// belongs to the estimates, of the model linear around them or with their weights, has no other
/// maxima.
HeldStarts held_starts(const SurfaceSetting& setting,
                       const data::Table& table,
                       const NaturalParameter& parameter) {
  const Method method = setting.fit.method;
  const bool belongs_to_estimates = method == Method::kLindstromBates ||
                                    method == Method::kGeneralized || setting.fit.reml ||
                                    setting.fit.specification.correlation.has_value();
  const bool is_alone = setting.estimate.size() < 2;
  if (belongs_to_estimates || is_alone || parameter.kind != ParameterKind::kFixed) return {};
  return [&setting, &table, name = parameter.name](double value) {
    ModelSpecification pooled = setting.model.specification();
    pooled.random.clear();
    const std::vector<std::string> names = pooled.coefficient_names();
    const auto place = static_cast<Index>(std::ranges::find(names, name) - names.begin());
    const NonlinearModel held(with_constants(pooled, {{name, value}}), table);
    std::vector<std::unique_ptr<HeldSurface>> starts;
    for (const VectorXd& start : search_starts(held, {})) {
      VectorXd all(start.size() + 1);
      all << start.head(place), value, start.tail(start.size() - place);
      starts.push_back(std::make_unique<HeldSurface>(setting.fit, table, all));
    }
    return starts;
  };
}

/// The condition of the intervals if coefficients are at their bounds; empty if none is.
std::string held_in_words(const FittedModel& fit) {
  std::vector<std::string> held;
  std::ranges::copy_if(fit.coefficient_names, std::back_inserter(held), [&](const auto& name) {
    return is_at_bound(fit, name);
  });
  if (held.empty()) return {};
  return fmt::format(", with {0} held at {1}; without, intervals are wider on one side",
                     enumerated(held),
                     held.size() == 1 ? "its bound" : "their bounds");
}

void add_profiles(const FittedModel& fit,
                  const data::Table& table,
                  const IntervalOptions& options,
                  Intervals& result) {
  const SurfaceSetting setting(fit, table, options.stop);
  if (const std::vector<std::string> kinks = setting.model.fixed_kinks();
      !kinks.empty() && is_linearized(fit)) {
    result.likelihood += fmt::format(
        ", which lacks the kinks of the formula in {}: compare with a bootstrap, or with profiles "
        "of `method=agq`",
        fmt::join(kinks, ", "));
  }
  const auto surface = make_surface(setting);
  std::vector<NaturalParameter> parameters = natural_parameters(setting, surface->layout());
  if (!fit.reml) {
    std::ranges::move(derived_parameters(setting, surface->layout()),
                      std::back_inserter(parameters));
  }
  const ProfileStart start = start_of(setting, *surface);
  std::vector<ParameterInterval> intervals(parameters.size());
  parallel_for(parameters.size(), options.threads, [&](std::size_t k) {
    const NaturalParameter& parameter = parameters[k];
    if (parameter.kind == ParameterKind::kSigma && fit.method == Method::kOrdinary) {
      intervals[k] = least_squares_sigma(fit, residual_freedom(setting), options.level);
      return;
    }
    const auto own = make_surface(setting);
    intervals[k] = profile_interval(*own,
                                    setting.variance,
                                    parameter,
                                    start,
                                    cut_of(setting, parameter.kind, options.level),
                                    held_starts(setting, table, parameter));
  });
  if (fit.reml) {
    const std::size_t before = result.parameters.size();
    add_wald_coefficients(fit, options.level, result);
    add_wald_derived(fit, options.level, result);
    for (std::size_t k = before; k < result.parameters.size(); ++k) {
      result.parameters[k].note =
          "Wald interval: the REML likelihood has no profile for fixed effects";
    }
  }
  result.parameters.insert(result.parameters.end(), intervals.begin(), intervals.end());
}

}  // namespace

Intervals confidence_intervals(const FittedModel& fit,
                               const data::Table& table,
                               const IntervalOptions& options) {
  if (!(options.level > 0.0 && options.level < 1.0)) {
    throw UsageError(
        fmt::format("the level of an interval must be between 0 and 1, not {}", options.level));
  }
  Intervals result{.method = options.method,
                   .level = options.level,
                   .likelihood = likelihood_in_words(fit) + held_in_words(fit)};
  if (options.method == IntervalMethod::kProfile) {
    add_profiles(fit, table, options, result);
    return result;
  }
  // This also checks the fit and the table.
  Intervals others = result;
  if (fit.method == Method::kOrdinary) {
    const SurfaceSetting setting(fit, table);
    const double reach =
        normal_quantile(options.level) / std::sqrt(2.0 * residual_freedom(setting));
    others.parameters.push_back({.kind = ParameterKind::kSigma,
                                 .name = "sigma",
                                 .estimate = fit.sigma,
                                 .lower = fit.sigma * std::exp(-reach),
                                 .upper = fit.sigma * std::exp(reach)});
  } else {
    add_wald_others(fit, table, others);
  }
  add_wald_coefficients(fit, options.level, result);
  result.parameters.insert(
      result.parameters.end(), others.parameters.begin(), others.parameters.end());
  add_wald_derived(fit, options.level, result);
  return result;
}

}  // namespace silvafit::fit
