// SPDX-License-Identifier: MIT
// Degrees of freedom of the variances of predictions.
#pragma once

#include <vector>

#include "model/small_matrix.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The variance of one prediction, and its parts that are proportional to the variance between
/// groups.
///
/// The part of Psi is Psi dV/dPsi, to first order the decrease of V if Psi goes to zero. V is
/// homogeneous in Psi and sigma^2, so that the parts and sigma^2 dV/dsigma^2 sum to V.
struct VarianceParts {
  double total = 0.0;
  SmallVector of_terms{};  ///< part of the covariance of the effects of each term
};

/// The t distribution of predictions by Satterthwaite's approximation.
///
/// It needs variances that are estimated independently; the terms of each are added before the sum
/// is squared. Without random effects the variance of a prediction is proportional to sigma^2, and
/// the degrees of freedom are those of the residual, which is exact in a linear model. With them,
/// the independent estimates are the variance between the curves of the groups (in a balanced
/// layout the mean square between groups) and the residual variance within groups. The former is
/// the sum of Psi and of the error of the estimated curves. The part V_b, which is proportional to
/// Psi, therefore belongs to the variance V_b / reliability, with the reliability the proportion of
/// Psi in that sum. Parts are not negative: the degrees of freedom are at least the smallest of the
/// estimates.
/// In the balanced one-way layout this is exact to the order of Satterthwaite's approximation, and
/// confidence intervals of the mean are those of the t test.
/// Source: Satterthwaite 1946, Biometrics Bulletin 2, 110-114.
class Freedom {
 public:
  explicit Freedom(const FittedModel& fit);

  /// The parts of f' C f, the variance of a prediction from the coefficients of the population.
  /// \param slope  (p) f, derivatives by the coefficients
  VarianceParts of_fixed(const Eigen::Ref<const VectorXd>& slope, double variance) const;

  /// Degrees of freedom of a variance.
  /// \param slope  (p) derivatives of the mean, the direction in which groups are compared
  double value(const VarianceParts& parts, const Eigen::Ref<const VectorXd>& slope) const;

 private:
  /// One term, p coefficients.
  struct Term {
    double freedom = 1.0;
    MatrixXd effects{};  ///< (p x p) Psi among the coefficients
    MatrixXd spread{};   ///< (p x p) of the groups' own curves: Psi and their errors
    /// (p x p) the part of Psi in the coefficients' covariance.
    MatrixXd in_fixed{};
  };
  static Term term(const FittedModel& fit,
                   const EstimatedEffects& effects,
                   const EffectUncertainty& uncertainty,
                   double freedom);
  static double reliability(const Term& term, const Eigen::Ref<const VectorXd>& slope);

  double residual_ = 1.0;
  std::vector<Term> terms_;
};

}  // namespace silvafit::fit
