// SPDX-License-Identifier: MIT
// Columns whose values are far from 0 compared with their range, such as calendar years.
#pragma once

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Names the columns of the formula that are the cause of a failed search, because changes of
/// coefficients by powers of ten give the same curve, and refuses fits whose variance function or
/// sigma is beyond the range of numbers because its column is far from 0.
void note_far_columns(const NonlinearModel& model, FittedModel& fit);

}  // namespace silvafit::fit
