// SPDX-License-Identifier: MIT
// Minima of functions whose gradient jumps.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

#include "optimization/quasi_newton.hpp"

namespace silvafit::fit {

/// A minimum where the gradient jumps.
struct KinkedMinimum {
  Eigen::VectorXd x{};  ///< on one side of all kinks, next to them within rounding
  double value = 0.0;
  Eigen::VectorXd gradient{};  ///< on the side of x
  Eigen::MatrixXd hessian{};   ///< on the side of x
  Eigen::MatrixXd normals{};  ///< (n x kinks) directions in which the gradient jumps, of length one
  /// g'H^-1 g over the directions that stay at the kinks: twice the decrease by a Newton step.
  double decrement = 0.0;
};

/// The coefficients in which the gradient jumps across kinks; none for a kink in other coordinates.
/// \param frame    (p x p) coefficients of the first p coordinates
/// \param normals  (n x kinks) as those of a minimum, n at least p
std::vector<Eigen::Index> kinked_coefficients(const Eigen::MatrixXd& frame,
                                              const Eigen::MatrixXd& normals);

/// Hessian at a point at which the gradient does not jump.
using HessianFunction = std::function<Eigen::MatrixXd(const Eigen::VectorXd& x)>;

/// A minimum at kinks, near a point where a search for a smooth minimum is stuck.
///
/// A kink is the surface on which one observation changes from one branch of the formula to
/// another: the function is smooth on both sides. The nearest one downhill is located by bisection;
/// Newton's method goes on along it, to the next kink if that is in the way. At the minimum the
/// function increases on both sides of each kink, and its gradient along them is zero.
/// \param function  in coordinates of order one
/// \param hessian   null: from differences of gradients on one side
/// \returns no value if no kink is near, or if no such minimum was reached
/// Source: Lewis and Overton 2013, Mathematical Programming 141: 135-163 (quasi-Newton searches end
///   at such points; the surface is their V-space).
std::optional<KinkedMinimum> minimum_at_kinks(const SmoothFunction& function,
                                              const Eigen::VectorXd& x,
                                              const HessianFunction& hessian = {});

}  // namespace silvafit::fit
