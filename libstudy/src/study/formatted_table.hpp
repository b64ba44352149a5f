// SPDX-License-Identifier: MIT
// A table for people and programs: CSV with all digits, Markdown and LaTeX with those that matter.
#pragma once

#include <string>
#include <variant>
#include <vector>

namespace silvafit::study {

/// How the values of a column are shown to people.
enum class ColumnKind {
  kText,       ///< as it is
  kCount,      ///< without decimals
  kEstimate,   ///< 5 significant digits
  kCriterion,  ///< 2 decimals: log-likelihood, AIC, BIC
  kShare,      ///< 4 decimals: R2, RMSE and the like
  kPercent,    ///< 1 decimal
  kP,          ///< 3 decimals, or < 0.001
};

struct TableColumn {
  std::string name{};   ///< in CSV: likelihood_ratio
  std::string title{};  ///< for people: Likelihood ratio
  ColumnKind kind = ColumnKind::kText;
};

/// Nothing, a text or a number; numbers that are not finite are shown as nothing.
using TableCell = std::variant<std::monostate, std::string, double>;
using TableRow = std::vector<TableCell>;

struct FormattedTable {
  std::string name{};     ///< of its files: candidates
  std::string caption{};  ///< what it shows, a sentence
  std::vector<TableColumn> columns{};
  std::vector<TableRow> rows{};
};

std::string to_csv(const FormattedTable& table);
/// A heading, the table of GitHub's Markdown, numbers to the right.
std::string to_markdown(const FormattedTable& table);
/// A tabular environment with \hline rules, without packages, in a table with its caption.
std::string to_latex(const FormattedTable& table);

}  // namespace silvafit::study
