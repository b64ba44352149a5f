// SPDX-License-Identifier: MIT
#include "silvafit/fit/estimates.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/fit_statistics.hpp"

namespace silvafit::fit {

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

MatrixXd EstimatedEffects::correlation() const { return correlation_of(covariance); }

// Published fits may lack the number of parameters; then there are no criteria.
double Estimates::aic() const {
  return parameter_count > 0 ? fit::aic(log_likelihood, parameter_count) : kNaN;
}
double Estimates::aicc() const {
  return parameter_count > 0 ? fit::aicc(log_likelihood, parameter_count, observations) : kNaN;
}
double Estimates::bic() const {
  return parameter_count > 0 ? fit::bic(log_likelihood, parameter_count, observations) : kNaN;
}

double Estimates::bic_groups() const {
  if (!has_random_effects() || parameter_count == 0) return kNaN;
  const auto groups = static_cast<Index>(random.front().labels.size());
  return fit::bic(log_likelihood, parameter_count, groups);
}

VectorXd Estimates::standard_errors() const { return covariance.diagonal().cwiseSqrt(); }

VectorXd Estimates::t_values() const { return estimate.cwiseQuotient(standard_errors()); }

VectorXd Estimates::p_values() const {
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

void Estimates::set_missing(const ModelSpecification& specification) {
  coefficient_names = specification.coefficient_names();
  const auto p = static_cast<Index>(coefficient_names.size());
  estimate = degrees_of_freedom = VectorXd::Constant(p, kNaN);
  covariance.setConstant(p, p, kNaN);
  random.resize(specification.random.size());
  for (std::size_t k = 0; k < random.size(); ++k) {
    EstimatedEffects& term = random[k];
    term.names = specification.random[k].coefficients;
    const auto q = static_cast<Index>(term.names.size());
    term.covariance.setConstant(q, q, kNaN);
    term.effects.setConstant(q, static_cast<Index>(term.labels.size()), kNaN);
  }
  variance = VarianceEstimate::missing(specification.variance);
  sigma = log_likelihood = kNaN;
  parameter_count = 0;
}

}  // namespace silvafit::fit
