// SPDX-License-Identifier: MIT
// The estimates of all methods: coefficients, random effects, variances, and their evidence.
#pragma once

#include <string>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/convergence.hpp"
#include "silvafit/fit/effect_uncertainty.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"
#include "silvafit/fit/variance_function.hpp"

namespace silvafit::fit {

/// A maximum of the likelihood, or a fixed point of Lindstrom and Bates' method, found by a search.
struct LocalOptimum {
  std::string origin{};         ///< name of the start of the search
  Eigen::VectorXd estimate{};   ///< (p) fixed effects
  double log_likelihood = 0.0;  ///< of the method
  /// Of Lindstrom and Bates' method: the likelihood at these estimates by Laplace's method, or by
  /// FOCEI if Laplace's is not valid for all fixed points; else NaN.
  double marginal_log_likelihood = kNaN;
};

/// The estimated random effects of one term: q coefficients, G groups.
struct EstimatedEffects {
  std::vector<std::string> names{};   ///< (q) coefficients
  std::vector<std::string> labels{};  ///< (G) of the groups; nested ones are `stand/plot`
  Eigen::MatrixXd covariance{};       ///< (q x q) Psi
  Eigen::MatrixXd effects{};          ///< (q x G) EBLUPs: modes given the data
  EffectUncertainty uncertainty{};    ///< of effects; unknown in older files

  /// (q) standard deviations.
  Eigen::VectorXd sd() const { return covariance.diagonal().cwiseSqrt(); }
  /// (q x q); NaN off the diagonal if a standard deviation is zero.
  Eigen::MatrixXd correlation() const;
};
/// (q x q) correlations of a covariance matrix; NaN off the diagonal if a variance is zero.
Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

/// The estimates of y_ij = f(beta + b_i; x_ij) + e_ij, b_i ~ N(0, Psi), Var e_ij = sigma^2 g_ij^2,
/// by any method. Missing values of a failed fit are NaN.
///
/// p coefficients, N observations.
struct Estimates {
  std::vector<std::string> coefficient_names{};
  Eigen::VectorXd estimate{};  ///< (p) beta
  /// (p x p) of the estimates. Least squares: sigma^2 (J'J)^-1, NaN where coefficients are
  /// confounded. Lindstrom and Bates: nlme's, with the factor N / (N - p) unless by restricted
  /// likelihood. Marginal likelihood: of the observed information.
  Eigen::MatrixXd covariance{};
  Eigen::VectorXd degrees_of_freedom{};  ///< (p) of the t tests; docs/inference.md has the rule
  /// Number of coefficients that are estimated between the groups, the coarser ones first, without
  /// an intercept: columns of the Jacobian that are constant in each group.
  std::vector<int> coefficients_between{};
  /// The terms of ModelSpecification::random, in their order; empty without random effects.
  std::vector<EstimatedEffects> random{};
  EffectCells cells{};  ///< of crossed terms; unknown in older files
  /// If constant-plus-power has become a constant variance, its constant is infinite and sigma is
  /// the residual standard deviation.
  VarianceEstimate variance{};
  double sigma = 0.0;
  double log_likelihood = 0.0;
  int parameter_count = 0;  ///< coefficients, (co)variances, sigma; 0 for a failed fit
  Eigen::Index observations = 0;
  Convergence convergence{};
  std::vector<LocalOptimum> optima{};  ///< of mixed fits: all found ones, this one first

  bool has_random_effects() const { return !random.empty(); }
  double aic() const;  ///< NaN if parameter_count is not known
  double aicc() const;
  double bic() const;
  /// With the number of independent groups (of the coarsest grouping) instead of that of
  /// observations; NaN without random effects.
  double bic_groups() const;
  Eigen::VectorXd standard_errors() const;
  Eigen::VectorXd t_values() const;
  /// p-value of the two-sided t test of each coefficient against zero.
  Eigen::VectorXd p_values() const;

  /// Gives a fit without a result the coefficients and terms of a specification, with missing
  /// values. Labels of groups are kept.
  void set_missing(const ModelSpecification& specification);
};

}  // namespace silvafit::fit
