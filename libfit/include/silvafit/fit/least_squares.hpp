// SPDX-License-Identifier: MIT
// Nonlinear least squares without start values from the user.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "silvafit/fit/estimates.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct LeastSquaresOptions {
  /// Start values by coefficient name; the others are searched.
  std::map<std::string, double> start{};
  /// One more start by parameter name: the catalogue's rules, evaluated on the data (see
  /// study::start_values).
  std::map<std::string, double> rule{};
  int maximum_iterations = 500;
  /// Whether further minima are searched, as starts of mixed models.
  bool other_minima = false;
  int further_starts = 0;  ///< of the search, besides its own
};

/// An ordinary least-squares fit: minimizes sum (y - f(beta))^2 over beta. Sigma has n - p in the
/// denominator; the log-likelihood is that at sigma^2 = SSE/n, infinite if the fit is exact.
struct LeastSquaresFit : Estimates {
  double sum_of_squares = 0.0;
  Eigen::VectorXd fitted{};  ///< (N) in model order
  /// (p) each: equivalent minima with exchanged terms, then other minima up to twice as high, if
  /// requested
  std::vector<Eigen::VectorXd> other_minima{};

  /// n - p.
  double residual_degrees_of_freedom() const;
};

/// Fits a model by least squares; random effects and the variance function of its specification are
/// ignored.
///
/// Coefficients that enter linearly are solved for (variable projection; their start values are not
/// used). A start with all coefficients determines the minimum; else the rules and a deterministic
/// search, scaled by the data, give several. Levenberg-Marquardt minimizes from the best,
/// and Newton steps add the last digits. A model with covariates starts from the fit without them,
/// so that it never fits worse. A failed fit is a result with converged = false and a convergence
/// message, not an exception; docs/mixed-effects.md lists the messages. For a formula whose
/// coefficients are all held, only sigma is estimated.
/// \throws DomainError with the row if its mean or derivative is not finite for any coefficients
LeastSquaresFit fit_least_squares(const NonlinearModel& model,
                                  const LeastSquaresOptions& options = {});

}  // namespace silvafit::fit
