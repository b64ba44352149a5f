// SPDX-License-Identifier: MIT
// The columns that the texts of a model refer to, and which of them contain names.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace silvafit::study {

/// The texts of a call that refer to columns; empty if they were not given.
struct ColumnTexts {
  std::vector<std::string> formulas{};
  std::vector<std::string> parameters{};  ///< sub-models, such as "b ~ 1 + C"
  std::string where{};
  std::string random{};
  std::string variance{};
  std::string correlation{};
};

/// Names in texts. Those of a formula may be parameters instead of columns.
struct ColumnUses {
  std::set<std::string> as_numbers{};  ///< with the responses
  std::set<std::string> as_names{};    ///< groups, strata, factors, columns compared with text
};

/// \throws FormulaError if a text cannot be read
ColumnUses column_uses(const ColumnTexts& texts);

/// Columns whose values keep their spelling ("07"): plots, trees, species, groups, strata, and
/// columns compared with text, unless the texts also read them as numbers.
/// \throws FormulaError if a text cannot be read
std::vector<std::string> name_columns(const ColumnTexts& texts);

}  // namespace silvafit::study
