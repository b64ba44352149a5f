// SPDX-License-Identifier: MIT
// The scale on which the profile of a parameter is searched.
#pragma once

#include <limits>

#include "inference/natural_parameters.hpp"

namespace silvafit::fit {

/// A scale of a parameter on which the signed root of the deviance is nearly linear, and the ends
/// of the parameter's range are finite if they can be reached.
struct ProfileScale {
  /// \param parameter  outlives the scale
  ProfileScale(const NaturalParameter& parameter, double estimate);

  double to(double value) const;
  double from(double t) const;

  const NaturalParameter& parameter;
  double reference = 1.0;  ///< typical size, of constants
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

}  // namespace silvafit::fit
