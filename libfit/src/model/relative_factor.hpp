// SPDX-License-Identifier: MIT
// The covariance of the random effects relative to sigma^2, as a factor L.
#pragma once

#include <utility>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/random_effects.hpp"

namespace silvafit::fit {

/// Psi / sigma^2 = L L' with L lower triangular; its diagonal may be zero or negative, so that the
/// boundary of the set of covariance matrices is an ordinary point for an optimizer. L is linear in
/// its parameters, but for compound symmetry, where it is homogeneous in the roots of the two
/// eigenvalues: Psi = alpha^2 I + (beta^2 - alpha^2)/q 11'.
class RelativeFactor {
 public:
  /// \param random  the form of the covariance
  /// \param scales  (q) the unit of each random effect: L acts on effects / scales. It only matters
  ///   for equal variances, which are equal in the effects' own units.
  RelativeFactor(const RandomEffects& random, VectorXd scales);

  Index size() const { return scales_.size(); }
  Index parameter_count() const;
  bool has_equal_variances() const { return is_identity_ || is_symmetric_; }
  /// Whether all pairs of several effects have one correlation: compound symmetry.
  bool has_common_correlation() const { return is_symmetric_; }
  /// (q x q) L for given parameters.
  MatrixXd factor(const VectorXd& parameters) const;
  /// Parameters of the L nearest to a diagonal one.
  VectorXd from_diagonal(const VectorXd& diagonal) const;
  /// Parameters of the factor of a positive semidefinite D, as far as the form can represent it.
  VectorXd from_covariance(const MatrixXd& relative_covariance) const;
  /// Parameters of a factor that has the form.
  VectorXd from_factor(const MatrixXd& factor) const;
  /// dF/d parameters from dF/dL.
  VectorXd gradient(const VectorXd& parameters, const MatrixXd& by_factor) const;

 private:
  VectorXd free_elements(const MatrixXd& factor) const;

  bool is_identity_ = false;
  bool is_symmetric_ = false;  ///< compound symmetry
  VectorXd scales_;
  std::vector<int> blocks_;  ///< sizes; effects of different blocks are independent
  /// Row and column of each free element, by blocks and columns; unused for equal variances.
  std::vector<std::pair<Index, Index>> elements_;
  VectorXd identity_;  ///< units of the rows of L for equal variances
};

/// The spherical effects v of effects b = L v, as far as a singular L can represent them.
/// \param factor   (q x q) L
/// \param effects  (q x G) b
MatrixXd spherical_effects(const MatrixXd& factor, const MatrixXd& effects);

}  // namespace silvafit::fit
