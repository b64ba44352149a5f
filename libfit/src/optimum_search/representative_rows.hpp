// SPDX-License-Identifier: MIT
// A part of many observations, on which starting points are compared.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The observations of some of the clusters, evenly chosen, or evenly chosen observations where
/// clusters are few: about 2,000.
std::vector<Eigen::Index> representative_rows(const NonlinearModel& model);

}  // namespace silvafit::fit
