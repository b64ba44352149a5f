// SPDX-License-Identifier: MIT
// What can be taken away from a model that has no good fit.
#pragma once

#include <string>

#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// "fewer random effects, a diagonal covariance matrix or a simpler variance function": as far as
/// the model has them, else "a curve with fewer coefficients".
std::string simpler_model(const ModelSpecification& specification);

}  // namespace silvafit::fit
