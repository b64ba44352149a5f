// SPDX-License-Identifier: MIT
// Nonlinear least squares without start values from the user.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>

#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct LeastSquaresOptions {
  /// Values to start from, by coefficient name; those not named are searched.
  std::map<std::string, double> start{};
  /// Further starts, tried before the search, by parameter name: rules of the catalogue, already
  /// evaluated.
  std::map<std::string, double> rule{};
  int maximum_iterations = 500;
};

/// An ordinary least-squares fit: minimises sum (y - f(beta))^2 over beta.
struct LeastSquaresFit {
  std::vector<std::string> coefficient_names{};
  Eigen::VectorXd estimate{};  ///< (p) beta
  Eigen::MatrixXd
      covariance{};  ///< (p x p) sigma^2 (J'J)^-1; NaN rows and columns for confounded coefficients
  double sum_of_squares = 0.0;
  double sigma = 0.0;           ///< residual standard deviation with n - p in the denominator
  double log_likelihood = 0.0;  ///< at the maximum-likelihood sigma^2 = SSE/n
  int parameter_count = 0;      ///< p + 1: sigma counts
  Eigen::Index observations = 0;
  Convergence convergence{};
  Eigen::VectorXd fitted{};  ///< (N) in model order

  double aic() const;
  double aicc() const;
  double bic() const;
  Eigen::VectorXd standard_errors() const;
  /// Residual degrees of freedom n - p.
  double degrees_of_freedom() const;
};

/// Fits a model by least squares; random effects and the variance function of its specification are
/// ignored.
///
/// Starts, in this order: the user's values, the rules, and a search over the nonlinear parameters
/// with the linear ones solved for (variable projection), scaled by the data. The best few are
/// polished by Levenberg-Marquardt (Ceres) to the last digits that doubles give. Deterministic. A
/// fit that fails is a result with converged = false and a verdict, not an exception. \throws
/// DomainError if the mean is not finite for any start because of the data (first offending row
/// named)
LeastSquaresFit fit_least_squares(const NonlinearModel& model,
                                  const LeastSquaresOptions& options = {});

}  // namespace silvafit::fit
