// SPDX-License-Identifier: MIT
// The words of R's arguments for the values of silvafit's options.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/parameter_intervals.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::r {

/// \throws UsageError for all of these if there is no such word; the message lists those there are
fit::Level parse_level(std::string_view word);
fit::NewGroups parse_new_groups(std::string_view word);
fit::SeenGroups parse_seen_groups(std::string_view word);
fit::IntervalKind parse_interval_kind(std::string_view word);

/// "fixed", "sd", "cor", "variance" or "sigma"
std::string kind_word(fit::ParameterKind kind);

}  // namespace silvafit::r
