// SPDX-License-Identifier: MIT
// A part of many observations, on which starting points are compared.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The observations of evenly chosen clusters, or evenly chosen observations if there are few
/// clusters: about 2,000.
std::vector<Eigen::Index> representative_rows(const NonlinearModel& model);

}  // namespace silvafit::fit
