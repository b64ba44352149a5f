// SPDX-License-Identifier: MIT
#include "silvafit/fit/fitted_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// In the order of the enumeration.
constexpr std::array<std::string_view, 7> kMethodNames{
    "ols", "gnls", "lb", "foce", "focei", "laplace", "agq"};

/// NaN off the diagonal where a standard deviation is zero.
MatrixXd correlation_of(const MatrixXd& covariance) {
  const VectorXd deviations = covariance.diagonal().cwiseSqrt();
  MatrixXd correlation = covariance;
  for (Index i = 0; i < correlation.rows(); ++i) {
    for (Index j = 0; j < correlation.cols(); ++j) {
      const double product = deviations[i] * deviations[j];
      correlation(i, j) = i == j ? 1.0 : (product > 0.0 ? correlation(i, j) / product : kNaN);
    }
  }
  return correlation;
}

}  // namespace

std::string method_text(Method method) {
  return std::string(kMethodNames[static_cast<std::size_t>(method)]);
}

Method parse_method(std::string_view text) {
  const auto* const found = std::ranges::find(kMethodNames, text);
  if (found == kMethodNames.end()) {
    throw UsageError(
        fmt::format("unknown method '{}'; available: {}", text, fmt::join(kMethodNames, ", ")));
  }
  return static_cast<Method>(found - kMethodNames.begin());
}

bool is_mixed(Method method) {
  return method != Method::kOrdinary && method != Method::kGeneralized;
}

Method default_method(const ModelSpecification& specification) {
  if (specification.random) return Method::kLindstromBates;
  return specification.variance.is_constant() ? Method::kOrdinary : Method::kGeneralized;
}

// Published fits may not say how many parameters they count; without them there are no criteria.
double FittedModel::aic() const {
  return parameter_count > 0 ? fit::aic(log_likelihood, parameter_count) : kNaN;
}
double FittedModel::aicc() const {
  return parameter_count > 0 ? fit::aicc(log_likelihood, parameter_count, observations) : kNaN;
}
double FittedModel::bic() const {
  return parameter_count > 0 ? fit::bic(log_likelihood, parameter_count, observations) : kNaN;
}

double FittedModel::bic_groups() const {
  if (!has_random_effects() || parameter_count == 0) return kNaN;
  const std::size_t groups = outer.names.empty() ? group_labels.size() : outer.labels.size();
  return fit::bic(log_likelihood, parameter_count, static_cast<Index>(groups));
}

VectorXd FittedModel::standard_errors() const { return covariance.diagonal().cwiseSqrt(); }

VectorXd FittedModel::t_values() const { return estimate.cwiseQuotient(standard_errors()); }

VectorXd FittedModel::p_values() const {
  VectorXd p = t_values();
  for (Index j = 0; j < p.size(); ++j) {
    double& value = p[j];
    if (std::isnan(value) || j >= degrees_of_freedom.size() || !(degrees_of_freedom[j] > 0.0)) {
      value = kNaN;
      continue;
    }
    const boost::math::students_t_distribution<double> distribution(degrees_of_freedom[j]);
    value = std::isinf(value)
                ? 0.0
                : 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(value)));
  }
  return p;
}

VectorXd FittedModel::random_sd() const { return random_covariance.diagonal().cwiseSqrt(); }

MatrixXd FittedModel::random_correlation() const { return correlation_of(random_covariance); }

VectorXd FittedModel::residual_sd(const Eigen::Ref<const VectorXd>& fitted,
                                  const data::Table& table) const {
  return sigma * relative_sd(variance, fitted, table);
}

double MixedEffectsFit::aic() const { return fit::aic(log_likelihood, parameter_count); }
double MixedEffectsFit::aicc() const {
  return fit::aicc(log_likelihood, parameter_count, observations);
}
double MixedEffectsFit::bic() const {
  return fit::bic(log_likelihood, parameter_count, observations);
}

VectorXd MixedEffectsFit::standard_errors() const { return covariance.diagonal().cwiseSqrt(); }
VectorXd MixedEffectsFit::random_sd() const { return random_covariance.diagonal().cwiseSqrt(); }

MatrixXd MixedEffectsFit::random_correlation() const { return correlation_of(random_covariance); }

}  // namespace silvafit::fit
