// SPDX-License-Identifier: MIT
// Values and ranges of coefficients in options.
#pragma once

#include <map>
#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::cli {

/// Reads `a=30,b=0.03`.
/// \param option  its name, for messages
/// \param form    of a part, such as NAME=VALUE
/// \throws UsageError that names the option and the part that cannot be read
std::map<std::string, double> parse_values(const std::string& text,
                                           const std::string& option,
                                           const std::string& form);

/// Reads `a=0:40,b=0:`, the value of --bound; a side without a number has no bound.
/// \throws UsageError as parse_values
std::map<std::string, fit::Bounds> parse_bounds(const std::string& text);

}  // namespace silvafit::cli
