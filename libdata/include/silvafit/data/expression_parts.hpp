// SPDX-License-Identifier: MIT
// The structure of an expression: its summands and factors, and how a name stands in it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"

namespace silvafit::data {

/// The summands of a sum, those that are subtracted as their negative; the whole if it is no sum.
std::vector<Expression> summands(const Expression& expression);

/// The factors of a product or quotient without signs, divisors as they are; the whole if it is
/// neither.
std::vector<Expression> factors(const Expression& expression);

/// Whether an expression is a name only, and not a comparison of a column with text.
bool is_name(const Expression& expression);

/// How a name stands in an expression.
struct NameUse {
  std::size_t mentions = 0;
  /// Some mention is a factor, or the base of a power.
  bool is_factor_or_base = false;
};
NameUse use_of(const Expression& expression, std::string_view name);

/// A name in a text.
struct NamePlace {
  std::string name{};
  std::size_t position = 0;  ///< column of its first character, from 1
};

/// The names of the right-hand side of a formula on which its value does not depend, because a
/// factor or an exponent of zero removes them.
/// \throws FormulaError as parse_formula
std::vector<NamePlace> vanished_names(std::string_view formula);

/// Some of the names, and the part of an expression through which alone they act on its value.
struct InseparableNames {
  std::vector<std::string> names{};
  std::string text{};  ///< of the part
};

/// Finds names that have a single effect together: two or more, each mentioned once, in a part
/// without any other variable, such as b and d in a + b*d*x. Numbers for them that give the part
/// the same value give the whole the same value, so that no data can distinguish them.
/// \param names  the variables to look for; others are data
std::vector<InseparableNames> inseparable_names(const Expression& expression,
                                                const std::vector<std::string>& names);

}  // namespace silvafit::data
