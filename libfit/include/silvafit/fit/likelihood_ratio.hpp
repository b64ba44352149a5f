// SPDX-License-Identifier: MIT
// Comparing fits: likelihood-ratio tests with the right reference, and information criteria.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A mixture of chi-squared distributions: weights[i] is the probability of i degrees of freedom
/// above `base`. The reference of a likelihood ratio where parameters lie on the edge of their
/// range under the hypothesis, such as variances at zero.
struct ChiBarSquared {
  int base = 0;
  std::vector<double> weights{1.0};  ///< add up to one

  /// P(mixture >= x); a component without degrees of freedom is a point mass at 0.
  double upper_tail(double x) const;
  /// "chi-squared with 2 degrees of freedom", "1/2 chi-squared(1) + 1/2 chi-squared(2)".
  std::string text() const;
};

/// Of k variances that are tested together, whose estimates are independent: binomial weights.
ChiBarSquared independent_variances(int k);

/// Of k variances whose unconstrained estimates have a covariance (up to a factor): the probability
/// that i of them are positive after projection on the quadrant in the metric of its inverse. In
/// closed form for k <= 2, else simulated.
/// \param covariance  (k x k) positive definite
/// \param draws       of the simulation
/// \throws UsageError if the matrix is not square and positive definite, or k > 12
/// Source: Silvapulle and Sen 2005, Constrained Statistical Inference, chapter 3.
ChiBarSquared correlated_variances(const Eigen::Ref<const Eigen::MatrixXd>& covariance,
                                   std::uint64_t seed = 1,
                                   int draws = 100000);

/// A likelihood-ratio test of a smaller model in a larger one.
struct NestedTest {
  double statistic = 0.0;  ///< twice the gain in log-likelihood
  int degrees_of_freedom = 0;
  double p_chi_squared = 1.0;  ///< by chi-squared with as many degrees of freedom
  /// By the reference that fits the hypothesis; the same as above where no variance is tested.
  double p = 1.0;
  ChiBarSquared reference{};
  std::string note{};  ///< what to know of the reference, or empty
};

/// How two fits relate.
struct Nesting {
  bool is_nested = false;
  std::string reason{};  ///< why there is no test, in words
  /// Number of regular parameters that the larger model has more: coefficients, covariances of
  /// effects that both have, parameters of the variance function.
  int regular = 0;
  /// Random effects that only the larger model has, and whose covariances with others (of old and
  /// of new ones) are free.
  int correlated_effects = 0;
  int new_covariances = 0;
  /// Random effects that only the larger model has, independent of all others.
  int independent_effects = 0;
  /// The smaller model has a parameter of the variance function at the end of its range.
  bool has_other_edge = false;
};

/// Whether `smaller` is a special case of `larger`, by their structure: the same formula,
/// sub-models with fewer covariates, fewer random effects or a simpler covariance, a simpler
/// variance function.
Nesting nesting(const FittedModel& larger, const FittedModel& smaller);

/// The test of two fits to the same observations by the same method.
/// \param variances  covariance of the variances that are tested if there are several independent
///   effects (see variance_covariance); without it they count as independent
/// \throws UsageError if there is no such test: the fits did not converge, are not nested, are to
///   other data or by other methods, or by restricted likelihood with other fixed effects
/// Source: Self and Liang 1987, J. Am. Stat. Assoc. 82, 605-610; Stram and Lee 1994, Biometrics 50,
/// 1171-1177.
NestedTest likelihood_ratio_test(const FittedModel& larger,
                                 const FittedModel& smaller,
                                 const std::optional<Eigen::MatrixXd>& variances = std::nullopt);

/// Asymptotic covariance, where they are zero, of the variances of random effects that `larger` has
/// more than `smaller`, from the expected information of the model linear around the estimates of
/// `smaller`; that on the variances that both have and on sigma is taken account of.
/// \param table  the rows that both were fitted to; one grouping
/// \throws UsageError if the larger model has no more random effects, or there are two groupings
Eigen::MatrixXd variance_covariance(const FittedModel& larger,
                                    const FittedModel& smaller,
                                    const data::Table& table);

/// A row of a comparison.
struct ComparedFit {
  const FittedModel* fit = nullptr;
  double aic_difference = 0.0;  ///< to the smallest
  double akaike_weight = 0.0;   ///< exp(-difference/2), adding up to one
};

/// The test of a fit against one before it in the comparison, or why there is none.
struct ComparedPair {
  std::size_t larger = 0;  ///< rows of the comparison
  std::size_t smaller = 0;
  std::optional<NestedTest> test{};
  std::string reason{};
};

struct Comparison {
  std::vector<ComparedFit> fits{};    ///< by number of parameters, those that converged
  std::vector<ComparedPair> pairs{};  ///< of neighbours
  /// Why criteria do not compare, or empty: other observations, other methods, other fixed effects
  /// with restricted likelihood. Then differences and weights are NaN.
  std::string reason{};
  std::vector<const FittedModel*> failed{};  ///< that did not converge
};

/// Compares fits by AIC and, from the fewest parameters on, each with the next.
/// \param fits  outlive the comparison
/// \throws UsageError for fewer than two fits
Comparison compare(const std::vector<const FittedModel*>& fits);

}  // namespace silvafit::fit
