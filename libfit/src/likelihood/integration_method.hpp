// SPDX-License-Identifier: MIT
// Which methods integrate the random effects, and how.
#pragma once

#include <optional>

#include "conditional_modes/observation_terms.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The integration of the random effects; nothing for lb, gnls and ols.
inline std::optional<Integration> integration_of(Method method) {
  switch (method) {
    case Method::kFirstOrder:
      return Integration::kFirstOrder;
    case Method::kInteraction:
      return Integration::kInteraction;
    case Method::kLaplace:
      return Integration::kLaplace;
    case Method::kQuadrature:
      return Integration::kQuadrature;
    default:
      return std::nullopt;
  }
}

/// The curvature that stands in the log-determinant of a likelihood.
inline Curvature curvature_of(Integration integration) {
  switch (integration) {
    case Integration::kFirstOrder:
      return Curvature::kFirstOrder;
    case Integration::kInteraction:
      return Curvature::kExpected;
    default:
      return Curvature::kFull;
  }
}

}  // namespace silvafit::fit
