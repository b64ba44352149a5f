// SPDX-License-Identifier: MIT
#include "silvafit/fit/bootstrap.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "resampling/resampled_data.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/fit/parameter_values.hpp"

namespace silvafit::fit {
namespace {

/// The result of one replicate.
struct Replicate {
  std::vector<NamedValue> values{};  ///< empty if it failed
  std::string failure{};             ///< the reason
  std::vector<std::string> boundary{};
};

/// Ratios and sigma relative to the reference stratum of an earlier fit, which is that of its first
/// row and may be another one in other data. They are NaN if the data do not have it.
void take_reference(const VarianceEstimate& earlier, FittedModel& fit) {
  for (std::size_t k = 0; k < fit.variance.factors.size(); ++k) {
    VarianceFactorEstimate& factor = fit.variance.factors[k];
    if (factor.ratio.size() == 0) continue;
    const auto found = std::ranges::find(factor.strata, earlier.factors[k].strata.front());
    const double first =
        found == factor.strata.end() ? kNaN : factor.ratio[found - factor.strata.begin()];
    fit.sigma *= first;
    factor.ratio /= first;
  }
}

/// The parameters of a fit without ratios of first strata, which are 1 by definition.
std::vector<NamedValue> estimated_parameters(FittedModel fit) {
  for (VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.ratio.size() == 0) continue;
    factor.strata.erase(factor.strata.begin());
    factor.ratio = VectorXd(factor.ratio.tail(factor.ratio.size() - 1));
  }
  return parameter_values(fit);
}

RandomEffects& outermost(ModelSpecification& specification) { return specification.random.front(); }

const RandomEffects& outermost(const ModelSpecification& specification) {
  return specification.random.front();
}

/// Replaces the names of drawn groups by those in the file, for messages.
void name_groups_as_in(const FittedModel& original, const std::string& drawn, FittedModel& fit) {
  const std::string& own = outermost(original.specification).group;
  outermost(fit.specification).group = own;
  const auto rename = [&](std::string& text) {
    for (std::size_t at = text.find(drawn); at != std::string::npos; at = text.find(drawn, at)) {
      text.replace(at, drawn.size(), own);
      at += own.size();
    }
  };
  for (Evidence& item : fit.convergence.evidence) rename(item.term);
}

Replicate refitted(Resampled&& data, const FittedModel& original, const FitModelOptions& options) {
  FitModelOptions from = options;
  from.from = &data.start;
  FittedModel fit = fit_model(data.specification, data.table, from).fit;
  take_reference(data.start.variance, fit);
  if (!data.drawn_group.empty()) name_groups_as_in(original, data.drawn_group, fit);
  Replicate result{.boundary = fit.convergence.boundary()};
  if (fit.convergence.converged()) {
    result.values = parameter_values(fit);
  } else {
    result.failure = fit.convergence.summary();
  }
  return result;
}

std::string bytes_of_replicate(const Replicate& replicate) {
  std::string bytes;
  std::vector<double> values;
  for (const NamedValue& value : replicate.values) values.push_back(value.value);
  append_numbers(values.data(), values.size(), bytes);
  for (const NamedValue& value : replicate.values) append_text(value.name, bytes);
  append_text(replicate.failure, bytes);
  for (const std::string& text : replicate.boundary) append_text(text, bytes);
  return bytes;
}

Replicate replicate_from(std::string_view bytes) {
  Replicate replicate;
  const std::vector<double> values = take_numbers(bytes);
  for (const double value : values) {
    replicate.values.push_back({.name = take_text(bytes), .value = value});
  }
  replicate.failure = take_text(bytes);
  while (!bytes.empty()) replicate.boundary.push_back(take_text(bytes));
  return replicate;
}

/// The value at a position between order statistics, counted from 1.
double order_statistic(const std::vector<double>& sorted, double position) {
  const double last = static_cast<double>(sorted.size());
  // (R + 1) p of 39 replicates and p = 0.025 is 1 but for rounding.
  const double inside = std::clamp(position, 1.0, last);
  const double whole = std::min(std::floor(inside), last - 1.0);
  const auto below = static_cast<std::size_t>(whole) - 1;
  return sorted[below] + (inside - whole) * (sorted[below + 1] - sorted[below]);
}

BootstrapParameter summary(const NamedValue& parameter, const VectorXd& values, double level) {
  BootstrapParameter result{
      .name = parameter.name, .estimate = parameter.value, .bias = kNaN, .standard_error = kNaN};
  std::vector<double> sorted;
  for (const double value : values) {
    if (std::isfinite(value)) sorted.push_back(value);
  }
  result.replicates = sorted.size();
  if (sorted.size() < 2) return result;
  std::ranges::sort(sorted);
  const Eigen::Map<const VectorXd> all(sorted.data(), static_cast<Index>(sorted.size()));
  const double mean = all.mean();
  result.bias = mean - parameter.value;
  result.standard_error =
      std::sqrt((all.array() - mean).square().sum() / static_cast<double>(sorted.size() - 1));
  if (sorted.size() < fewest_replicates(level)) return result;
  const double count = static_cast<double>(sorted.size()) + 1.0;
  const double tail = 0.5 * (1.0 - level);
  result.percentile = {.low = order_statistic(sorted, count * tail),
                       .high = order_statistic(sorted, count * (1.0 - tail))};
  result.basic = {.low = 2.0 * parameter.value - result.percentile.high,
                  .high = 2.0 * parameter.value - result.percentile.low};
  return result;
}

void check(const FittedModel& fit, const BootstrapOptions& options) {
  if (!fit.convergence.converged()) {
    throw UsageError("a fit that has not converged cannot be bootstrapped");
  }
  if (!(fit.sigma > 0.0)) {
    throw UsageError(
        "perfect fit: the residual standard deviation is 0, so there is nothing to draw from");
  }
  if (!options.group.empty() && options.resample == Resample::kParametric) {
    throw UsageError("groups are for `resample=cases`; the parametric bootstrap draws no groups");
  }
  if (options.replicates < 2) throw UsageError("a bootstrap needs at least 2 replicates");
  if (!(options.level > 0.0 && options.level < 1.0)) {
    throw UsageError(
        fmt::format("the level of an interval must be between 0 and 1, not {}", options.level));
  }
}

/// The values of a replicate in the order of the fit's parameters; a stratum that a replicate does
/// not have leaves NaN.
VectorXd in_order(const std::vector<NamedValue>& parameters,
                  const std::vector<NamedValue>& values) {
  VectorXd result = VectorXd::Constant(static_cast<Index>(parameters.size()), kNaN);
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto found = std::ranges::find(values, parameters[k].name, &NamedValue::name);
    if (found != values.end()) result[static_cast<Index>(k)] = found->value;
  }
  return result;
}

std::vector<Replicate> run(const FittedModel& fit,
                           const data::Table& table,
                           const BootstrapOptions& options) {
  std::unique_ptr<const ParametricDraw> parametric;
  std::unique_ptr<const CaseDraw> cases;
  if (options.resample == Resample::kParametric) {
    parametric = std::make_unique<ParametricDraw>(fit, table);
  } else {
    cases = std::make_unique<CaseDraw>(fit, table, options.group);
  }
  const FitModelOptions refit = refit_options(fit, options.refit);
  std::atomic<std::size_t> done{0};
  const auto replicate = [&](std::size_t i) {
    Random random(options.seed, i + 1);
    Replicate result;
    try {
      result = refitted(parametric ? parametric->draw(random) : cases->draw(random), fit, refit);
    } catch (const Error& error) {
      // An error with the data of one replicate does not stop the others.
      result = {.failure = error.message()};
    }
    if (options.progress) options.progress(++done, options.replicates);
    return bytes_of_replicate(result);
  };
  std::vector<Replicate> replicates;
  for (const std::string& bytes : farm(options.replicates, options.threads, replicate)) {
    replicates.push_back(replicate_from(bytes));
  }
  return replicates;
}

/// Equal ones by their text.
std::vector<CountedReason> commonest_first(const std::map<std::string, std::size_t>& counts) {
  std::vector<CountedReason> result;
  for (const auto& [reason, count] : counts) result.push_back({reason, count});
  std::ranges::stable_sort(result, std::ranges::greater{}, &CountedReason::replicates);
  return result;
}

}  // namespace

std::size_t fewest_replicates(double level) {
  constexpr double kRounding = 1e-9;
  return static_cast<std::size_t>(std::ceil(2.0 / (1.0 - level) - 1.0 - kRounding));
}

Bootstrap bootstrap(const FittedModel& fit,
                    const data::Table& table,
                    const BootstrapOptions& options) {
  check(fit, options);
  const std::vector<Replicate> replicates = run(fit, table, options);
  const std::vector<NamedValue> parameters = estimated_parameters(fit);
  Bootstrap result{.resample = options.resample,
                   .seed = options.seed,
                   .level = options.level,
                   .replicates = options.replicates};
  result.values.setConstant(
      static_cast<Index>(parameters.size()), static_cast<Index>(replicates.size()), kNaN);
  std::map<std::string, std::size_t> failures;
  std::map<std::string, std::size_t> at_boundary;
  for (std::size_t i = 0; i < replicates.size(); ++i) {
    if (replicates[i].values.empty()) {
      ++failures[replicates[i].failure];
      continue;
    }
    ++result.converged;
    result.values.col(static_cast<Index>(i)) = in_order(parameters, replicates[i].values);
    for (const std::string& what : replicates[i].boundary) ++at_boundary[what];
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    result.parameters.push_back(
        summary(parameters[k], result.values.row(static_cast<Index>(k)), options.level));
  }
  result.failures = commonest_first(failures);
  result.at_boundary = commonest_first(at_boundary);
  return result;
}

}  // namespace silvafit::fit
