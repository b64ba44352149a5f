// SPDX-License-Identifier: MIT
// Estimates of growth by stratum.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "silvafit/stand/growth.hpp"

namespace silvafit::stand {

/// Estimates of the periods with one number; the last: all strata. None if no such plot has an
/// area.
/// \param areas_ha     size of each plot of the report in ratios; NaN: unknown
/// \param whole_ha     the same of whole plots (SampledArea::whole_m2)
/// \param sizes        areas [ha] or weights of the strata; may be empty
std::vector<StratumGrowth> strata_of_period(const GrowthReport& report,
                                            const std::vector<double>& areas_ha,
                                            const std::vector<double>& whole_ha,
                                            std::size_t period,
                                            const std::map<std::string, double>& sizes,
                                            bool are_weights,
                                            const StratumSettings& settings);

}  // namespace silvafit::stand
