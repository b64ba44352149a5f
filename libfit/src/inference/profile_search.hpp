// SPDX-License-Identifier: MIT
// The limits of a profile likelihood.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "inference/natural_parameters.hpp"
#include "likelihood/likelihood_surface.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
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

/// The likelihood in the units of another point, whose coefficients may differ by powers of ten.
struct HeldSurface {
  /// \param estimate  (p) of the coefficients that the fit does not hold
  HeldSurface(const FittedModel& of, const data::Table& table, const Eigen::VectorXd& estimate);
  HeldSurface(const HeldSurface&) = delete;
  HeldSurface& operator=(const HeldSurface&) = delete;
  ~HeldSurface() = default;

  FittedModel fit;
  SurfaceSetting setting;
  std::unique_ptr<LikelihoodSurface> surface;
};

/// Points near maxima of the likelihood with one coefficient held at a value, from a search without
/// a start. It throws DomainError if the formula has no value there.
using HeldStarts = std::function<std::vector<std::unique_ptr<HeldSurface>>(double value)>;

/// The profile interval of a parameter: each limit is searched by secants of the signed root of the
/// deviance, with the rest of the parameters at their constrained maximum. That is the one next to
/// the last; where there is none, and at each limit, a search from all sides follows, since the
/// maximum may move to infinity and come back from the other side.
/// \param surface  used by this search only
/// \param starts   of a coefficient; null for other parameters
ParameterInterval profile_interval(LikelihoodSurface& surface,
                                   const VarianceModel& variance,
                                   const NaturalParameter& parameter,
                                   const ProfileStart& start,
                                   const ProfileCut& cut,
                                   const HeldStarts& starts = {});

}  // namespace silvafit::fit
