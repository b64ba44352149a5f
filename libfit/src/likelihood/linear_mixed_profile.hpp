// SPDX-License-Identifier: MIT
// The likelihood of a linear mixed model with beta and sigma profiled out, and its exact gradient.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

class EffectLayout;

/// The columns of X that form Z, for each term of random effects.
struct RandomColumns {
  std::vector<std::vector<Index>> terms{};  ///< (q) of each
  std::vector<Index> cluster_begin{};       ///< (C + 1) first group of each cluster
  /// The places of effects; null of nested terms.
  std::shared_ptr<const EffectLayout> crossed{};
  std::vector<std::vector<Index>> of_groups{};  ///< (G) the group of each term it is in
};

/// L with Psi / sigma^2 = L L', (q x q), lower triangular, of each term.
using RelativeFactors = std::vector<MatrixXd>;

/// The sufficient data of a linear mixed model: per group the cross products
/// [X w]' G^-2 [X w], width p + 1, and their derivatives by m variance parameters.
///
/// The derivatives form a Taylor series around the parameters d of the weights:
/// term 0, then the m first derivatives, then the second ones of pairs(). Pairs that are not
/// listed have none.
///
/// Crossed terms have many small groups, of which only the rows of the columns with random effects
/// are needed beside the sum over all groups.
class GroupMoments {
 public:
  GroupMoments() = default;
  /// \param rows  ascending, those that are kept of each group's matrices; none: all
  GroupMoments(Index width,
               Index groups,
               Index parameters,
               std::vector<std::pair<Index, Index>> pairs,
               std::vector<Index> rows = {});

  Index width() const { return width_; }
  /// (r) the kept rows.
  const std::vector<Index>& rows() const { return rows_; }
  bool has_all_rows() const { return std::ssize(rows_) == width_; }
  Index groups() const { return products_.cols(); }
  Index parameters() const { return parameters_; }
  const std::vector<std::pair<Index, Index>>& pairs() const { return pairs_; }
  Index terms() const { return 1 + parameters_ + static_cast<Index>(pairs_.size()); }
  /// The (r x width) rows of the matrix of a term, which is symmetric.
  double* term(Index group, Index term) { return products_.col(group).data() + term * size(); }
  const double* term(Index group, Index term) const {
    return products_.col(group).data() + term * size();
  }
  /// (r width x G) the same of all groups.
  auto term(Index term) const { return products_.middleRows(term * size(), size()); }
  /// Keeps the rows of a group.
  /// \param products  (width x width x terms)
  void keep(Index group, const double* products);
  /// (width x width) the sum of a term over all groups.
  MatrixXd total(Index term) const;
  /// \param totals  (width^2 x terms) of some groups, if not all of their rows are kept
  void add_totals(const MatrixXd& totals) { totals_ += totals; }
  bool all_finite() const {
    return products_.allFinite() && totals_.allFinite() && sum_log_.allFinite();
  }
  /// Converts the columns of X to other units: each is divided by its size.
  void divide_columns(const VectorXd& sizes);
  /// (terms) the sum of log g and its derivatives.
  VectorXd& sum_log() { return sum_log_; }
  const VectorXd& sum_log() const { return sum_log_; }

  /// (m) typical derivatives of log g, initially zeros. The common part of all g belongs to sigma,
  /// so that the series is accurate if the differences from these are small.
  void set_center(const VectorXd& center) { center_ = center; }

  /// (terms) the weight of each term at d + displacement: of exp(-2 s) times the second-order
  /// series of exp(2 s) g^-2, where s = displacement' center.
  VectorXd term_weights(const VectorXd& displacement) const;
  /// (m) a gradient by the displacement from one by the term weights.
  VectorXd by_displacement(const VectorXd& by_term, const VectorXd& displacement) const;
  /// The sum of log g at d + displacement, and its gradient.
  double sum_log_at(const VectorXd& displacement) const;
  VectorXd sum_log_gradient(const VectorXd& displacement) const;

 private:
  Index size() const { return std::ssize(rows_) * width_; }

  Index width_ = 0;
  Index parameters_ = 0;
  std::vector<std::pair<Index, Index>> pairs_;
  std::vector<Index> rows_;
  MatrixXd products_;  ///< (r width terms x G)
  MatrixXd totals_;    ///< (width^2 x terms) sums, if not all rows are kept
  VectorXd sum_log_;
  VectorXd center_;
};

/// Parameters of a linear mixed model with given values instead of maximization.
struct HeldParameters {
  VectorXd coefficients{};  ///< (p) beta; empty where it is the generalized least-squares one
  double sigma2 = 0.0;      ///< 0 where it is S / N
};

/// A linear mixed model w = X beta + sum over the terms of Z b + e on N observations.
struct LinearMixedModel {
  GroupMoments moments{};
  RandomColumns random{};
  Index observations = 0;
  /// Number of columns of X, the last ones, that form Z only and have no beta. The width of the
  /// moments is p + random_only + 1.
  Index random_only = 0;
  /// Restricted likelihood: of the residuals, beta integrated out.
  bool restricted = false;
  /// log|X'V^-1 X| in the coefficients' own units, less that of this X; only for restricted
  /// likelihood.
  double log_units = 0.0;
  unsigned threads = 1;  ///< does not change the result
};

/// The profiled model at one covariance.
struct LinearMixedProfile {
  double minus_log_likelihood = 0.0;
  double sum_of_squares = 0.0;        ///< S = weighted squares + penalty at that beta
  double sigma2 = 0.0;                ///< S / N, restricted S / (N - p), or as held
  VectorXd coefficients{};            ///< (p) generalized least-squares beta, or as held
  MatrixXd information{};             ///< (p x p) X' V^-1 X, with V relative to sigma^2
  std::vector<MatrixXd> spherical{};  ///< (q x groups) of each term: v with b = L v
  bool is_valid = false;              ///< false if X' V^-1 X is not positive definite
  RelativeFactors by_factor{};        ///< dF/dL, lower triangles
  RelativeFactors by_covariance{};    ///< dF/dD, symmetric, of D = L L'
  VectorXd by_variance{};             ///< (m) dF/d displacement
  VectorXd by_coefficients{};         ///< (p) dF/d beta; zero except for rounding unless it is held
  double by_log_sigma = 0.0;          ///< dF/d log sigma at L; zero unless sigma is held
};

/// F = -log-likelihood = N/2 (log(2 pi S/N) + 1) + sum log|A| / 2 + sum log g, where A = I +
/// L'Z'V^-1 Z L of each group and then, with V including the groups' effects, of each cluster; with
/// crossed terms of all effects of a cluster at once. Restricted, N becomes N - p and log|X'V^-1 X|
/// / 2 is added. Without derivatives only the first six members and the derivatives by beta and
/// sigma are filled. Held parameters are not maximized over: then the first part is N/2 log(2 pi
/// sigma^2) + S / (2 sigma^2).
/// \param displacement  (m) of the variance parameters from those of the moments
/// Source: Pinheiro and Bates 2000, sections 2.2 and 5.2.
LinearMixedProfile profile(const LinearMixedModel& model,
                           const RelativeFactors& factors,
                           const VectorXd& displacement,
                           bool with_derivatives,
                           const HeldParameters& held = {});

/// (G) the weighted squares of the linear model at given effects: those of w - X beta - Z b; of
/// crossed terms (1) their sum.
VectorXd expected_squares(const LinearMixedModel& model,
                          const RelativeFactors& factors,
                          const LinearMixedProfile& at);

}  // namespace silvafit::fit
