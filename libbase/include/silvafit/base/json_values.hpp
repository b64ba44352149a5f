// SPDX-License-Identifier: MIT
// Values that may be missing, as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string_view>
#include <vector>

namespace silvafit {

/// The number, or null if it is not finite.
nlohmann::ordered_json number_or_null(double value);

/// Each number, or null where it is not finite.
nlohmann::ordered_json numbers_or_null(const std::vector<double>& values);

/// The text, or null if it is empty.
nlohmann::ordered_json text_or_null(std::string_view text);

}  // namespace silvafit
