// SPDX-License-Identifier: MIT
// What to write instead of functions of R that a formula does not know.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

/// The rest of the message "unknown function 'NAME'": the formula of a self-starting model with
/// the arguments that were given, another function, or all functions that are available.
/// \param arguments  texts of the arguments
std::string advice_on_function(std::string_view name, const std::vector<std::string>& arguments);

}  // namespace silvafit::data
