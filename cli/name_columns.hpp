// SPDX-License-Identifier: MIT
// Which columns of a file hold names, not numbers.
#pragma once

#include <string>
#include <vector>

namespace silvafit::cli {

/// The texts of a command that speak of columns; empty where they were not given.
struct ColumnTexts {
  std::vector<std::string> formulas{};
  std::vector<std::string> parameters{};  ///< sub-models, such as "b ~ 1 + C"
  std::string where{};
  std::string random{};
  std::string variance{};
};

/// Columns whose values keep their spelling ("07"): plots, trees, species, groups, strata, and what
/// is compared with text, unless the command also reads them as numbers.
/// \throws FormulaError if a text cannot be read
std::vector<std::string> name_columns(const ColumnTexts& texts);

}  // namespace silvafit::cli
