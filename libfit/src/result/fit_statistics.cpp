// SPDX-License-Identifier: MIT
#include "silvafit/fit/fit_statistics.hpp"

#include <cmath>
#include <numbers>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {

FitStatistics fit_statistics(const Eigen::Ref<const VectorXd>& observed,
                             const Eigen::Ref<const VectorXd>& predicted) {
  const Index n = observed.size();
  if (n < 1 || predicted.size() != n) {
    throw UsageError("the numbers of predictions and observations must be equal and at least 1");
  }
  const Eigen::ArrayXd error = (observed - predicted).array();
  const double mean_error = error.mean();
  const double spread =
      n > 1 ? (error - mean_error).square().sum() / static_cast<double>(n - 1) : 0.0;
  const double total = (observed.array() - observed.mean()).square().sum();
  // Equal observations have no variance to explain.
  const double r2 = total > 0.0 ? 1.0 - error.square().sum() / total : kNaN;
  return {.r2 = r2,
          .mean_error = mean_error,
          .rmse = std::sqrt(mean_error * mean_error + spread),
          .mae = error.abs().mean()};
}

double least_squares_log_likelihood(double sum_of_squares, Index observations) {
  const auto n = static_cast<double>(observations);
  return -0.5 * n * (std::log(2.0 * std::numbers::pi * sum_of_squares / n) + 1.0);
}

double aic(double log_likelihood, int parameters) {
  return -2.0 * log_likelihood + 2.0 * parameters;
}

double aicc(double log_likelihood, int parameters, Index observations) {
  const double spare = static_cast<double>(observations) - parameters - 1.0;
  if (spare <= 0.0) return kInfinity;
  return aic(log_likelihood, parameters) + 2.0 * parameters * (parameters + 1.0) / spare;
}

double bic(double log_likelihood, int parameters, Index observations) {
  return -2.0 * log_likelihood + parameters * std::log(static_cast<double>(observations));
}

}  // namespace silvafit::fit
