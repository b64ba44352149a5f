// SPDX-License-Identifier: MIT
// The profile of a linear mixed model with crossed random effects.
#pragma once

#include "likelihood/linear_mixed_profile.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// See profile(); by a sparse factorization of the Hessian of all effects of a cluster.
LinearMixedProfile crossed_profile(const LinearMixedModel& model,
                                   const RelativeFactors& factors,
                                   const VectorXd& displacement,
                                   bool with_derivatives,
                                   const HeldParameters& held);

/// (width x width) cross products of columns after standard normal effects b = L v are integrated
/// out.
/// \param moments  without variance parameters
MatrixXd without_crossed_effects(const RandomColumns& random,
                                 const RelativeFactors& factors,
                                 const GroupMoments& moments);

}  // namespace silvafit::fit
