// SPDX-License-Identifier: MIT
// The observed information of a fit: covariances of all of its parameters.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Covariances by the inverse Hessian of the negative log-likelihood at the estimates.
///
/// K parameters: estimated coefficients, standard deviations, correlations, parameters of
/// the variance function, sigma, in the order and with the names of confidence_intervals().
struct ObservedInformation {
  std::string likelihood{};           ///< name of the likelihood
  std::vector<std::string> names{};   ///< (K)
  Eigen::VectorXd estimate{};         ///< (K)
  std::vector<std::string> scales{};  ///< (K) "identity", "log", "fisher": log((1+r)/(1-r))
  /// (K x K) on these scales. Rows and columns of parameters at a boundary are NaN.
  Eigen::MatrixXd covariance{};
  /// (p x p) of the estimated coefficients, without nlme's factor N / (N - p); empty for restricted
  /// likelihood, which has no coefficients.
  Eigen::MatrixXd fixed_covariance{};
  /// Smallest eigenvalue of the Hessian with a diagonal of ones: near 0, some parameters are hardly
  /// identifiable.
  double smallest_curvature = 0.0;
};

/// The information in the likelihood that the fit maximized: for foce, focei, laplace and agq the
/// marginal one, for ols and gnls that of the nonlinear model, for lb that of the model linear
/// around the estimates (nlme's apVar). For ols sigma^2 has n - p in the denominator, and the
/// Hessian is exact, with symbolic second derivatives of the mean, where FittedModel::covariance
/// has Gauss and Newton's (J'J)^-1.
/// \param table  the rows of the fit
/// \throws UsageError if the fit did not converge or the table is another one
ObservedInformation observed_information(const FittedModel& fit, const data::Table& table);

}  // namespace silvafit::fit
