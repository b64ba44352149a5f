// SPDX-License-Identifier: MIT
#include "result/earlier_fit.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "model/group_labels.hpp"
#include "model/variance_weights.hpp"
#include "result/group_coefficients.hpp"

namespace silvafit::fit {
namespace {

using Kind = VarianceFactor::Kind;

std::optional<VectorXd> coefficients_of(const FittedModel& earlier, const NonlinearModel& model) {
  const LabelNumbers known = numbered(earlier.coefficient_names);
  VectorXd result(model.coefficient_count());
  for (Index j = 0; j < result.size(); ++j) {
    const auto found = known.find(model.coefficient_names()[static_cast<std::size_t>(j)]);
    if (found == known.end()) return std::nullopt;
    result[j] = earlier.estimate[found->second];
  }
  return result.allFinite() ? std::optional(result) : std::nullopt;
}

/// (S) values by stratum; unknown strata get the mean of the known ones.
VectorXd by_stratum(const VarianceFactorEstimate& earlier,
                    const VectorXd& values,
                    const std::vector<std::string>& strata) {
  if (values.size() == 0) return values;
  const LabelNumbers known = numbered(earlier.strata);
  VectorXd result = VectorXd::Constant(static_cast<Index>(strata.size()), values.mean());
  for (std::size_t s = 0; s < strata.size(); ++s) {
    const auto found = known.find(strata[s]);
    if (found != known.end()) result[static_cast<Index>(s)] = values[found->second];
  }
  return result;
}

bool is_like(const FittedModel& earlier, const ModelSpecification& specification) {
  const bool has_same_effects = std::ranges::equal(earlier.specification.random,
                                                   specification.random,
                                                   {},
                                                   &RandomEffects::coefficients,
                                                   &RandomEffects::coefficients);
  return has_same_effects && earlier.random.size() == specification.random.size() &&
         (earlier.specification.variance.is_constant() ||
          earlier.variance.function().text() == specification.variance.text());
}

/// The start of a variance function after a constant variance: of the same typical size.
void start_variance(const FittedModel& earlier, const NonlinearModel& model, MixedEffectsFit& fit) {
  const VarianceModel variance(model.specification().variance, VarianceData::of(model));
  const VectorXd start = variance.start();
  const VectorXd fitted = model.mean_at(fit.estimate);
  const double mean_log =
      variance.scale(fitted, start, false).sum_log / static_cast<double>(fitted.size());
  fit.variance = variance.estimate(start);
  fit.sigma = earlier.sigma * variance.sigma_factor(start) * std::exp(-mean_log);
}

}  // namespace

ResidualVariance residual_variance_for(const Estimates& estimates, const NonlinearModel& model) {
  ResidualVariance result{.variance = estimates.variance, .sigma = estimates.sigma};
  for (VarianceFactorEstimate& factor : result.variance.factors) {
    if (factor.factor.stratum.empty()) continue;
    const std::vector<std::string>& strata = model.strata(factor.factor.stratum).labels;
    const VarianceFactorEstimate before = factor;
    factor.delta = by_stratum(before, before.delta, strata);
    factor.constant = by_stratum(before, before.constant, strata);
    factor.ratio = by_stratum(before, before.ratio, strata);
    factor.strata = strata;
    if (factor.ratio.size() == 0) continue;
    const double first = factor.ratio[0];
    result.sigma *= first;
    factor.ratio /= first;
  }
  return result;
}

std::optional<MixedEffectsFit> as_start(const FittedModel& earlier, const NonlinearModel& model) {
  const ModelSpecification& specification = model.specification();
  if (!is_like(earlier, specification) || !(earlier.sigma > 0.0)) return std::nullopt;
  const std::optional<VectorXd> coefficients = coefficients_of(earlier, model);
  if (!coefficients) return std::nullopt;
  MixedEffectsFit fit;
  fit.estimate = *coefficients;
  name_terms(model, fit);
  bool is_known = true;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const EstimatedEffects& known = earlier.random[k];
    EstimatedEffects& term = fit.random[k];
    term.covariance = known.covariance;
    term.effects = effects_by_label(known.labels, known.effects, term.labels);
    is_known = is_known && term.covariance.allFinite() && term.effects.allFinite();
  }
  if (earlier.specification.variance.is_constant() && !specification.variance.is_constant()) {
    start_variance(earlier, model, fit);
  } else {
    ResidualVariance residual = residual_variance_for(earlier, model);
    fit.variance = std::move(residual.variance);
    fit.sigma = residual.sigma;
  }
  return is_known ? std::optional(std::move(fit)) : std::nullopt;
}

}  // namespace silvafit::fit
