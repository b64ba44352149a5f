// SPDX-License-Identifier: MIT
// Test of a minimum from the gradient and a Hessian of limited accuracy.
#pragma once

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Newton's decrement and the sign of the curvature, direction by direction, with variables scaled
/// so that the Hessian has ones on its diagonal.
///
/// The likelihood of a boundary (singular) fit has directions without curvature, such as rotations
/// of a factor that has lost rank; there the gradient has to be zero as well. So does a likelihood
/// with parameters that are not identifiable. This class does not distinguish the two cases: see
/// mixed_effects/confounded_variances.hpp.
class CurvatureCertificate {
 public:
  /// \param hessian   (n x n) from differences of gradients; its asymmetry is a measure of the
  ///   error of its eigenvalues
  /// \param gradient  (n)
  CurvatureCertificate(const MatrixXd& hessian, const VectorXd& gradient);

  /// g'H^-1 g, twice the decrease by a Newton step; infinite if it is not known.
  double decrement() const { return decrement_; }
  /// The direction of the most negative curvature, one standard deviation long; empty if no
  /// curvature is significantly negative.
  const VectorXd& downwards() const { return downwards_; }

 private:
  double decrement_ = 0.0;
  VectorXd downwards_;
};

/// The inverse of a Hessian over the directions in which it is positive. It is not valid for a
/// parameter that has a component in one of the other directions. NaN if the Hessian is not finite.
MatrixXd informed_inverse(const MatrixXd& hessian);

/// Whether no curvature is negative but for rounding errors.
bool is_of_minimum(const MatrixXd& hessian);

struct InformedCovariance {
  MatrixXd covariance{};         ///< (m x m)
  Index unknown_directions = 0;  ///< without curvature, and on which one of the functions depends
};
/// The covariance T H^-1 T' of linear functions of the variables; NaN for those that depend on a
/// direction in which the Hessian is not positive: nothing is known of their errors.
/// \param transform  (m x n) T
InformedCovariance informed_covariance(const MatrixXd& hessian, const MatrixXd& transform);

}  // namespace silvafit::fit
