// SPDX-License-Identifier: MIT
// Nonlinear mixed-effects models, and generalized least squares as the case without random effects.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// How far a search for the highest maximum goes.
enum class SearchEffort {
  /// From the pooled least-squares fit, and from others only where that does not converge.
  kQuick,
  /// From all starting points that are known, with checks of the maximum; docs/local-maxima.md.
  kThorough,
};

/// A maximum of the likelihood, or a fixed point of Lindstrom and Bates' method, that a search
/// found.
struct LocalOptimum {
  std::string origin{};         ///< what the search started from
  Eigen::VectorXd estimate{};   ///< (p) fixed effects
  double log_likelihood = 0.0;  ///< of the method
  /// Of Lindstrom and Bates' method: the likelihood at these estimates by Laplace's method, or by
  /// FOCEI where Laplace's does not hold for all fixed points; else NaN.
  double marginal_log_likelihood = std::numeric_limits<double>::quiet_NaN();
};

struct MixedEffectsOptions {
  /// (p) further coefficients to start from; the fit with the highest likelihood is taken.
  std::vector<Eigen::VectorXd> starts{};
  int maximum_iterations = 200;  ///< alternations of the two steps
  /// Restricted maximum likelihood instead of maximum likelihood: of the model that is linear
  /// around the estimates (R nlme's REML).
  bool reml = false;
  /// Called with one line for each iteration, if given.
  std::function<void(const std::string&)> trace{};
};

/// Estimated random effects of the coarser of two nested groupings: r coefficients, S groups.
struct OuterRandomEffects {
  std::vector<std::string> names{};   ///< (r), empty without a coarser grouping
  std::vector<std::string> labels{};  ///< (S)
  Eigen::MatrixXd covariance{};       ///< (r x r)
  Eigen::MatrixXd effects{};          ///< (r x S) EBLUPs
};

/// A fitted model: y_ij = f(beta + b_i; x_ij) + e_ij, b_i ~ N(0, Psi), Var e_ij = sigma^2 g_ij^2.
///
/// p coefficients, q of them with random effects, G groups, N observations in the model's order.
struct MixedEffectsFit {
  std::vector<std::string> coefficient_names{};
  Eigen::VectorXd estimate{};  ///< (p) fixed effects
  /// (p x p) covariance of the fixed effects: by Lindstrom and Bates' method with nlme's factor
  /// N / (N - p), unless by restricted likelihood; of marginal likelihood by the observed
  /// information
  Eigen::MatrixXd covariance{};
  std::vector<std::string> random_names{};  ///< (q)
  std::vector<std::string> group_labels{};  ///< (G)
  Eigen::MatrixXd random_covariance{};      ///< (q x q) Psi
  Eigen::MatrixXd random_effects{};         ///< (q x G) EBLUPs: modes given the data
  OuterRandomEffects outer{};               ///< of the coarser of two nested groupings
  double sigma = 0.0;
  VarianceEstimate variance{};
  double log_likelihood = 0.0;
  int parameter_count = 0;  ///< coefficients, covariance and variance parameters, sigma
  Eigen::Index observations = 0;
  Eigen::VectorXd degrees_of_freedom{};  ///< (p) of the t tests, as nlme counts them
  /// Coefficients that are estimated between the groups, the coarser ones first.
  std::vector<int> coefficients_between{};
  Convergence convergence{};
  Eigen::VectorXd fitted_population{};   ///< (N) f(beta)
  Eigen::VectorXd fitted_conditional{};  ///< (N) f(beta + b)
  Eigen::VectorXd residual_sd{};         ///< (N) sigma g
  Eigen::Index floored_variances =
      0;  ///< fitted values too near zero for a power, which were floored
  std::vector<LocalOptimum> optima{};  ///< all that were found, this one first

  double aic() const;
  double aicc() const;
  double bic() const;
  Eigen::VectorXd standard_errors() const;
  Eigen::VectorXd random_sd() const;
  /// (q x q); NaN off the diagonal where a standard deviation is zero.
  Eigen::MatrixXd random_correlation() const;
};

/// How the random effects are integrated out of the likelihood.
enum class Integration {
  kFirstOrder,   ///< FOCE: first order around the modes, residual variance at b = 0
  kInteraction,  ///< FOCEI: the same with the residual variance at the modes
  kLaplace,      ///< Laplace's method with all second derivatives
  kQuadrature,   ///< adaptive Gauss-Hermite quadrature
};

struct MarginalOptions {
  /// (p) further coefficients to start from, as in MixedEffectsOptions.
  std::vector<Eigen::VectorXd> starts{};
  int quadrature_points = 7;  ///< a random effect
  /// Called with one line for each value of the likelihood, if given.
  std::function<void(const std::string&)> trace{};
};

/// Fits by maximum marginal likelihood.
///
/// Starts from a fit by Lindstrom and Bates' method, converged or not, and follows the exact
/// gradient of the likelihood to where the Newton decrement vanishes. Standard errors are those of
/// the observed information. A fit that fails is a result with converged = false and a verdict.
/// \param start  (p) coefficients to start from: the pooled least-squares fit
/// \throws UsageError without random effects, or if there are too many for quadrature, which takes
///   at most 3, of one grouping, and 20,000 points over them
/// Source: docs/marginal-likelihood.md.
MixedEffectsFit fit_marginal(const NonlinearModel& model,
                             const Eigen::VectorXd& start,
                             Integration integration,
                             const MarginalOptions& options = {});

/// Fits by the method of Lindstrom and Bates, with one grouping or two nested ones: R nlme's
/// objective, by maximum or restricted maximum likelihood.
///
/// Alternates penalized nonlinear least squares in beta and b with the profile likelihood of the
/// model that is linear around them, until both leave the estimates unchanged. Psi = sigma^2 L L'
/// is never inverted, so that a singular Psi is an ordinary point; the reported log-likelihood is
/// that of the linearized model, as nlme's. Without random effects it is generalized nonlinear
/// least squares (nlme's gnls). A fit that fails is a result with converged = false and a verdict,
/// not an exception.
/// \param start  (p) coefficients to start from: the pooled least-squares fit
/// Source: Lindstrom and Bates 1990, Biometrics 46, 673-687; Pinheiro and Bates 2000, chapters 5
/// and 7.
MixedEffectsFit fit_lindstrom_bates(const NonlinearModel& model,
                                    const Eigen::VectorXd& start,
                                    const MixedEffectsOptions& options = {});

}  // namespace silvafit::fit
