// SPDX-License-Identifier: MIT
// The sentence of each kind of finding.
#pragma once

#include <string_view>

#include "silvafit/fit/finding.hpp"

namespace silvafit::fit {

/// Names are {a}, {b}, {c}, or all of them: {names}, {each} with semicolons. Values are {x}, {y},
/// {z}; {point} is the names with the last values, {simpler} what can be taken from the model,
/// {unbounded} the clause on coefficients that grow. [one|several] depends on the number of names,
/// or without names on the first value.
std::string_view text_of(Finding::Kind kind);

}  // namespace silvafit::fit
