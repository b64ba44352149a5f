// SPDX-License-Identifier: MIT
// Whether the random effects of two fits to the same observations have the same groups.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Why it is not known that a grouping of two fits parts the observations alike; empty where it
/// does.
///
/// A fit keeps the labels of its groups and not the observations in them. With the same column and
/// the same observations the groups are the same if their labels are; the plots of `stand/plot` are
/// those of `plot` if each label of a plot is found in one stand only.
/// \param group  column of a grouping that both have
std::string obstacle_to_same_groups(const FittedModel& larger,
                                    const FittedModel& smaller,
                                    const std::string& group);

}  // namespace silvafit::fit
