// SPDX-License-Identifier: MIT
// Whether the data can determine crossed random effects.
#pragma once

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Checks that each crossed term has several groups, and fewer random effects than there are rows.
/// \throws InputError that names the term, its groups and the rows
void check_crossed_groups(const NonlinearModel& model);

}  // namespace silvafit::fit
