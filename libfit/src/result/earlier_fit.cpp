// SPDX-License-Identifier: MIT
#include "result/earlier_fit.hpp"

#include <string>
#include <utility>
#include <vector>

#include "model/group_labels.hpp"
#include "result/group_coefficients.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
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

/// (S) values by stratum, the mean of those that are known for others.
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

/// The variance with the strata of a model, whose first one need not be that of the earlier fit.
void take_variance(const FittedModel& earlier, const NonlinearModel& model, MixedEffectsFit& fit) {
  fit.sigma = earlier.sigma;
  fit.variance = earlier.variance;
  for (VarianceFactorEstimate& factor : fit.variance.factors) {
    if (factor.factor.stratum.empty()) continue;
    const std::vector<std::string>& strata = model.strata(factor.factor.stratum).labels;
    const VarianceFactorEstimate before = factor;
    factor.delta = by_stratum(before, before.delta, strata);
    factor.constant = by_stratum(before, before.constant, strata);
    factor.ratio = by_stratum(before, before.ratio, strata);
    factor.strata = strata;
    if (factor.ratio.size() == 0) continue;
    const double first = factor.ratio[0];
    fit.sigma *= first;
    factor.ratio /= first;
  }
}

bool have_same_effects(const std::optional<RandomEffects>& a,
                       const std::optional<RandomEffects>& b) {
  if (!a || !b) return !a && !b;
  return a->coefficients == b->coefficients;
}

bool is_like(const FittedModel& earlier, const ModelSpecification& specification) {
  return have_same_effects(earlier.specification.random, specification.random) &&
         have_same_effects(earlier.specification.outer_random, specification.outer_random) &&
         earlier.variance.function().text() == specification.variance.text();
}

}  // namespace

std::optional<MixedEffectsFit> as_start(const FittedModel& earlier, const NonlinearModel& model) {
  const ModelSpecification& specification = model.specification();
  if (!is_like(earlier, specification) || !(earlier.sigma > 0.0)) return std::nullopt;
  const std::optional<VectorXd> coefficients = coefficients_of(earlier, model);
  if (!coefficients) return std::nullopt;
  MixedEffectsFit fit;
  fit.estimate = *coefficients;
  fit.random_effects = MatrixXd::Zero(0, model.group_count());
  fit.outer.effects = MatrixXd::Zero(0, model.cluster_count());
  if (specification.random) {
    fit.random_covariance = earlier.random_covariance;
    fit.random_effects =
        effects_by_label(earlier.group_labels, earlier.random_effects, model.group_labels());
  }
  if (specification.outer_random) {
    fit.outer.covariance = earlier.outer.covariance;
    fit.outer.effects =
        effects_by_label(earlier.outer.labels, earlier.outer.effects, model.outer_labels());
  }
  take_variance(earlier, model, fit);
  const bool is_known = fit.random_covariance.allFinite() && fit.random_effects.allFinite() &&
                        fit.outer.covariance.allFinite() && fit.outer.effects.allFinite();
  return is_known ? std::optional(std::move(fit)) : std::nullopt;
}

}  // namespace silvafit::fit
