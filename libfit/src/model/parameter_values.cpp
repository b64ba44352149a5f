// SPDX-License-Identifier: MIT
#include "silvafit/fit/parameter_values.hpp"

#include <fmt/format.h>

namespace silvafit::fit {
namespace {

/// \param group  for two groupings: " | stand"
void add_covariance(const std::vector<std::string>& names,
                    const MatrixXd& covariance,
                    const std::string& group,
                    std::vector<NamedValue>& values) {
  const VectorXd deviations = covariance.diagonal().cwiseSqrt();
  const MatrixXd correlation = correlation_of(covariance);
  const auto count = static_cast<Index>(names.size());
  const auto name = [&](Index k) { return names[static_cast<std::size_t>(k)]; };
  for (Index k = 0; k < count; ++k) {
    values.push_back({fmt::format("sd({}{})", name(k), group), deviations[k]});
  }
  for (Index j = 0; j < count; ++j) {
    for (Index i = j + 1; i < count; ++i) {
      values.push_back({fmt::format("cor({}, {}{})", name(j), name(i), group), correlation(i, j)});
    }
  }
}

/// Correlations that the form of the covariance fixes at zero are not parameters.
void add_level(const RandomEffects& random,
               const MatrixXd& covariance,
               const std::string& group,
               std::vector<NamedValue>& values) {
  Index begin = 0;
  for (const int size : random.block_sizes()) {
    const auto first = random.coefficients.begin() + begin;
    add_covariance(
        {first, first + size}, covariance.block(begin, begin, size, size), group, values);
    begin += size;
  }
}

void add_factor(const VarianceFactorEstimate& estimate,
                const std::string& prefix,
                std::vector<NamedValue>& values) {
  const auto add = [&](const char* what, const VectorXd& numbers, bool is_held) {
    if (is_held) return;
    for (Index s = 0; s < numbers.size(); ++s) {
      const std::string& stratum = estimate.strata[static_cast<std::size_t>(s)];
      values.push_back(
          {fmt::format("{}{}{}{}", prefix, what, stratum.empty() ? "" : " of ", stratum),
           numbers[s]});
    }
  };
  add("delta", estimate.delta, estimate.factor.delta.has_value());
  add("constant", estimate.constant, estimate.factor.constant.has_value());
  add("ratio", estimate.ratio, false);
}

}  // namespace

std::vector<NamedValue> parameter_values(const FittedModel& fit) {
  std::vector<NamedValue> values;
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    values.push_back({fit.coefficient_names[k], fit.estimate[static_cast<Index>(k)]});
  }
  const std::vector<RandomEffects>& terms = fit.specification.random;
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    const std::string group = terms.size() > 1 ? " | " + terms[k].group_name() : "";
    add_level(terms[k], fit.random[k].covariance, group, values);
  }
  for (const VarianceFactorEstimate& factor : fit.variance.factors) {
    const bool is_only = fit.variance.factors.size() == 1;
    add_factor(factor, is_only ? "" : factor.factor.text() + " ", values);
  }
  if (const auto& correlation = fit.variance.correlation) {
    for (std::size_t k = 0; k < correlation->names.size(); ++k) {
      values.push_back({correlation->names[k], correlation->values[static_cast<Index>(k)]});
    }
  }
  values.push_back({"sigma", fit.sigma});
  for (const DerivedQuantity& quantity : fit.specification.derived) {
    values.push_back({quantity.name, quantity.at(fit.coefficient_names, fit.estimate)});
  }
  return values;
}

}  // namespace silvafit::fit
