// SPDX-License-Identifier: MIT
// Goodness of fit and confidence intervals as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "silvafit/fit/parameter_intervals.hpp"

namespace silvafit::fit {

nlohmann::ordered_json statistics_json(const FitStatistics& values);

/// The object under the key `intervals` of a fit; docs/json.md lists its keys. Limits that are not
/// known or do not exist are null, and a note says which of the two and why.
nlohmann::ordered_json intervals_json(const Intervals& intervals);

/// \throws InputError that names file and key
Intervals read_intervals(const data::JsonReader& json);

}  // namespace silvafit::fit
