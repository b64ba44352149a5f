// SPDX-License-Identifier: MIT
// What to write instead of functions of R that a formula does not know.
#pragma once

#include <string>
#include <string_view>

namespace silvafit::data {

/// The rest of the message "unknown function 'NAME'": what to write instead, or a function with a
/// similar name.
std::string advice_on_function(std::string_view name);

}  // namespace silvafit::data
