// SPDX-License-Identifier: MIT
// Agreement of predictions with observations.
#pragma once

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// With residuals e = y - prediction of n observations.
struct FitStatistics {
  double r2 = kNaN;          ///< 1 - sum e^2 / sum (y - mean y)^2; NaN if y is constant
  double mean_error = kNaN;  ///< E = mean e
  double rmse = kNaN;        ///< sqrt(E^2 + sum (e - E)^2 / (n - 1))
  double mae = kNaN;         ///< mean |e|
};

/// \param observed, predicted  (N), N >= 1; for N = 1 the standard deviation of the errors is zero
/// Source: Wang et al. 2023, Forests 14, 639 (definitions that agree with its published values).
FitStatistics fit_statistics(const Eigen::Ref<const Eigen::VectorXd>& observed,
                             const Eigen::Ref<const Eigen::VectorXd>& predicted);

/// Log-likelihood of least squares at sigma^2 = SSE/n: -n/2 (log(2 pi SSE/n) + 1).
double least_squares_log_likelihood(double sum_of_squares, Eigen::Index observations);

/// Information criteria; k counts all estimated parameters, sigma among them.
double aic(double log_likelihood, int parameters);
/// With the small-sample correction 2k(k+1)/(n-k-1); infinite if n <= k + 1.
double aicc(double log_likelihood, int parameters, Eigen::Index observations);
double bic(double log_likelihood, int parameters, Eigen::Index observations);

}  // namespace silvafit::fit
