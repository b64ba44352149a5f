// SPDX-License-Identifier: MIT
// The right side of a sub-model by R's rules: terms of variables, by +, -, :, * and ^.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"

namespace silvafit::fit {

/// An operand: a column, a function of columns, or a comparison.
struct TermVariable {
  std::string label{};  ///< as written, e.g. "C", "log(dbh)" or "(Year == 1989)"
  data::Expression value;
  std::string column{};      ///< of a bare name, and of factor(column)
  bool is_factor = false;    ///< factor(column)
  std::size_t position = 0;  ///< in the text, from 1
};

/// A product of variables, by their numbers, in the order of its first occurrence.
using Term = std::vector<std::size_t>;

/// The terms of `b ~ x*z`: x, z and x:z, ordered by their number of variables, as in R.
struct TermFormula {
  std::string parameter{};
  bool has_intercept = true;
  std::vector<TermVariable> variables{};  ///< each once, in the order of the text
  std::vector<Term> terms{};
};

/// \throws FormulaError if the text is not a sub-model, or if R and arithmetic would differ
TermFormula parse_terms(std::string_view text);

/// "x:z": the label of a term whose variables have these labels.
std::string product_label(const std::vector<std::string>& labels);

}  // namespace silvafit::fit
