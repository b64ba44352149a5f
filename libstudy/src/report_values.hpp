// SPDX-License-Identifier: MIT
// Numbers and fits in the form that all pages read.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study::report {

/// The number, or null if it is not finite.
nlohmann::ordered_json number(double value);
nlohmann::ordered_json numbers(const std::vector<double>& values);

/// What `silvafit fit --json` prints of a fit, without the time that it took: that would make two
/// pages of the same study differ.
nlohmann::ordered_json fit_object(const fit::FittedModel& fit);

}  // namespace silvafit::study::report
