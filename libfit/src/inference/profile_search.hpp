// SPDX-License-Identifier: MIT
// The limits of a profile likelihood.
#pragma once

#include <Eigen/Core>

#include "inference/natural_parameters.hpp"
#include "likelihood/likelihood_surface.hpp"
#include "silvafit/fit/intervals.hpp"

namespace silvafit::fit {

/// The start of the profile of one parameter: the maximum of the likelihood.
struct ProfileStart {
  double value = 0.0;         ///< F at the maximum
  Eigen::MatrixXd hessian{};  ///< of F there
  Eigen::MatrixXd inverse{};  ///< of the Hessian, over the directions in which it is positive
};

/// Decreases of twice the log-likelihood at the limits of an interval.
struct ProfileCut {
  double both_sides = 0.0;  ///< for an estimate inside its range
  double one_side = 0.0;    ///< for an estimate on the boundary
};

/// The profile interval of a parameter: each limit is searched by secants of the signed root of the
/// deviance, with the rest of the parameters at their constrained maximum.
/// \param surface  used by this search only
ParameterInterval profile_interval(LikelihoodSurface& surface,
                                   const VarianceModel& variance,
                                   const NaturalParameter& parameter,
                                   const ProfileStart& start,
                                   const ProfileCut& cut);

}  // namespace silvafit::fit
