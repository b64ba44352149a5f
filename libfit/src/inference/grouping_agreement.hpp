// SPDX-License-Identifier: MIT
// Whether the random effects of two fits to the same observations have the same groups.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The reason why groups of observations of two fits may differ in a grouping; empty if
/// it has.
///
/// A fit stores the labels of its groups, not their observations. With the same column and the same
/// observations, equal labels mean equal groups; the plots of `stand/plot` are those of `plot` if
/// each label of a plot occurs in one stand only.
/// \param group  column of a grouping that both have
std::string obstacle_to_same_groups(const FittedModel& larger,
                                    const FittedModel& smaller,
                                    const RandomEffects& term);

}  // namespace silvafit::fit
