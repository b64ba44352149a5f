// SPDX-License-Identifier: MIT
// Equations solved symbolically for a part of one side.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/expression.hpp"

namespace silvafit::data {

/// `part = value`, which is equivalent to `expression = outcome`.
struct SolvedEquation {
  Expression part;   ///< the smallest part of the expression that contains all unknowns
  Expression value;  ///< without unknowns if the outcome has none
};

/// Solves `expression = outcome` for the part of the expression that contains the unknowns.
///
/// Inverts operations from the outermost inwards: + - * / ^, squares, exp, logarithms, sqrt. Stops
/// where both operands contain unknowns, or where an operation has no inverse. Of the two roots of
/// a square, the positive one is used. Example: 1.3 + d^2/(a + b*d) = h for a and b gives
/// a + b*d = d^2/(h - 1.3).
SolvedEquation solve_for(const Expression& expression,
                         const std::vector<std::string>& unknowns,
                         const Expression& outcome);

}  // namespace silvafit::data
