// SPDX-License-Identifier: MIT
// The estimated random effects of a fit, by group of its data.
#pragma once

#include <Eigen/Core>

#include "likelihood/likelihood_surface.hpp"

namespace silvafit::fit {

/// (p x G) random effects of each group, summed over both groupings; zero for coefficients without
/// random effects.
Eigen::MatrixXd group_effects(const SurfaceSetting& setting);

}  // namespace silvafit::fit
