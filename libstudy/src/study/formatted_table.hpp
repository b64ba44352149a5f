// SPDX-License-Identifier: MIT
// A table as CSV with all digits, and as Markdown and LaTeX with rounded numbers.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "silvafit/base/enum_words.hpp"

namespace silvafit::study {

/// Rounding of the values of a column in Markdown and LaTeX.
enum class ColumnKind {
  kText,       ///< as it is
  kCount,      ///< without decimals
  kEstimate,   ///< 5 significant digits
  kCriterion,  ///< 2 decimals: log-likelihood, AIC, BIC
  kShare,      ///< 4 decimals: R2, RMSE and the like
  kPercent,    ///< 1 decimal
  kP,          ///< 3 decimals, or < 0.001
};
constexpr std::array<std::string_view, 7> words_of(ColumnKind /*kind*/) {
  return {"text", "count", "estimate", "criterion", "share", "percent", "p"};
}

struct TableColumn {
  std::string name{};   ///< in CSV: likelihood_ratio
  std::string title{};  ///< in Markdown and LaTeX: Likelihood ratio
  ColumnKind kind = ColumnKind::kText;
};

/// A number with a text before and after it, such as the stars of its significance. It is rounded
/// in every format.
struct MarkedNumber {
  std::string before{};
  double value = 0.0;
  std::string after{};
};

/// Nothing, a text or a number; a number that is not finite gives an empty cell.
using TableCell = std::variant<std::monostate, std::string, double, MarkedNumber>;
using TableRow = std::vector<TableCell>;

struct FormattedTable {
  std::string name{};     ///< of its files: candidates
  std::string caption{};  ///< a sentence on the content
  std::vector<TableColumn> columns{};
  std::vector<TableRow> rows{};
};

std::string to_csv(const FormattedTable& table);
/// A heading, the table of GitHub's Markdown, numbers to the right with the minus sign U+2212.
std::string to_markdown(const FormattedTable& table);
/// Tabular environments with \hline rules, each in a table with the caption. A page has room for 45
/// rows; more rows continue in a further table. No package is needed; with graphicx, tables of many
/// columns are as wide as the text at most.
std::string to_latex(const FormattedTable& table);

/// A cell as text: rounded by the kind of its column, with the minus sign U+2212.
std::string shown_text(const TableCell& cell, ColumnKind kind);

}  // namespace silvafit::study
