// SPDX-License-Identifier: MIT
// When a search for conditional modes has reached the precision of the numbers.
#pragma once

namespace silvafit::fit {

/// A Newton decrement below this that no longer falls is rounding.
constexpr double kRoundedDecrement = 1e-12;

}  // namespace silvafit::fit
