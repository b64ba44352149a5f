// SPDX-License-Identifier: MIT
// The layout of the parameters of a likelihood in one vector of numbers of order one.
#pragma once

#include <string>
#include <vector>

#include "model/coefficient_frame.hpp"
#include "model/relative_factor.hpp"
#include "model/variance_weights.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The layout of the parameters in a vector x of numbers of order one:
/// x = (T^-1 beta, factor of each term, internal variance parameters, log of the internal sigma). A
/// factor is U^-1 L of Psi = L L', lower triangular. T and U are the coefficients' frame.
class SurfaceLayout {
 public:
  /// \param beta_count  p, or 0 if the likelihood is that of contrasts free of beta
  SurfaceLayout(const NonlinearModel& model,
                const VarianceModel& variance,
                CoefficientFrame frame,
                Index beta_count);

  Index size() const { return sigma_at() + 1; }
  Index beta_count() const { return beta_; }
  Index variance_at() const { return begins_.back(); }
  Index variance_count() const { return variance_; }
  Index sigma_at() const { return variance_at() + variance_; }

  const CoefficientFrame& frame() const { return frame_; }
  std::size_t terms() const { return factors_.size(); }
  const RelativeFactor& factor(std::size_t term) const { return factors_[term]; }
  Index factor_at(std::size_t term) const { return begins_[term]; }
  /// The coefficients.
  VectorXd beta(const VectorXd& x) const { return frame_.beta * x.head(beta_); }
  /// The gradient by the first p elements of x from that by the coefficients.
  VectorXd beta_gradient(const VectorXd& by_beta) const {
    return frame_.beta.transpose() * by_beta;
  }
  /// (q x q) L of a term, in the coefficients' own units.
  MatrixXd own_factor(const VectorXd& x, std::size_t term) const;
  /// x with other elements of a factor.
  void set_own_factor(std::size_t term, const MatrixXd& own, VectorXd& x) const;
  /// The gradient by the elements of a factor in x from that by L, of which the lower triangle is
  /// used.
  VectorXd factor_gradient(const VectorXd& x, std::size_t term, const MatrixXd& by_own) const;
  /// The gradient by L, lower triangular, from one by x.
  MatrixXd own_factor_gradient(std::size_t term, const VectorXd& gradient) const;
  /// The parameters of a term's factor.
  VectorXd factor_part(const VectorXd& x, std::size_t term) const {
    return x.segment(factor_at(term), factor(term).parameter_count());
  }
  VectorXd variance_part(const VectorXd& x) const { return x.segment(variance_at(), variance_); }
  /// The name of an element of x: "b", "sd(b)", "cor(a, b)", "the variance function", "sigma".
  std::string name(const NonlinearModel& model, Index at) const;
  /// x with standard deviations of 0 inside: the likelihood is stationary at 0, so that a search
  /// from there would not find that it rises.
  VectorXd lifted(VectorXd x) const;
  /// Parameters as a vector.
  /// \param covariances  Psi of each term, in the coefficients' own units
  /// \param log_sigma    of the internal sigma
  VectorXd coordinates(const VectorXd& beta,
                       const std::vector<MatrixXd>& covariances,
                       const VectorXd& variance,
                       double log_sigma) const;

 private:
  CoefficientFrame frame_;
  Index beta_ = 0;
  Index variance_ = 0;
  std::vector<RelativeFactor> factors_;
  std::vector<Index> begins_;  ///< of each term's parameters, and of those of the variance
};

}  // namespace silvafit::fit
