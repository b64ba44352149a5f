// SPDX-License-Identifier: MIT
// Bootstrap, cross-validation and comparisons as JSON; docs/json.md lists the keys.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/cross_validation.hpp"

namespace silvafit::fit {

/// Names of compared fits.
using FitNames = std::map<const FittedModel*, std::string>;

/// Numbers that are not finite are null.
nlohmann::ordered_json json_of(const Bootstrap& bootstrap);
nlohmann::ordered_json json_of(const CrossValidation& result);
/// \param names  of each fit of the comparison
nlohmann::ordered_json json_of(const Comparison& comparison, const FitNames& names);

}  // namespace silvafit::fit
