// SPDX-License-Identifier: MIT
#include "study/formatted_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "silvafit/data/csv.hpp"

namespace silvafit::study {
namespace {

std::string rounded(double value, ColumnKind kind) {
  constexpr double kSmallestP = 0.001;
  switch (kind) {
    case ColumnKind::kCount:
      return fmt::format("{:.0f}", value);
    case ColumnKind::kCriterion:
      return fmt::format("{:.2f}", value);
    case ColumnKind::kShare:
      return fmt::format("{:.4f}", value);
    case ColumnKind::kPercent:
      return fmt::format("{:.1f}", value);
    case ColumnKind::kP:
      return value < kSmallestP ? "< 0.001" : fmt::format("{:.3f}", value);
    case ColumnKind::kText:
    case ColumnKind::kEstimate:
      return fmt::format("{:.5g}", value);
  }
  return "";
}

/// The rounded cell with an ASCII minus sign.
std::string shown(const TableCell& cell, ColumnKind kind) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  if (const auto* marked = std::get_if<MarkedNumber>(&cell)) {
    if (!std::isfinite(marked->value)) return "";
    return marked->before + rounded(marked->value, kind) + marked->after;
  }
  const auto* number = std::get_if<double>(&cell);
  return number != nullptr && std::isfinite(*number) ? rounded(*number, kind) : "";
}

/// Replaces an ASCII minus sign in numbers, "-0.5" and "1e-05", by the typographic one.
std::string with_minus_signs(const std::string& text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_sign =
        text[i] == '-' && i + 1 < text.size() && text[i + 1] >= '0' && text[i + 1] <= '9';
    result += is_sign ? "\u2212" : text.substr(i, 1);
  }
  return result;
}

std::string csv_text(const TableCell& cell, ColumnKind kind) {
  const auto* number = std::get_if<double>(&cell);
  if (std::holds_alternative<MarkedNumber>(cell)) return data::plain_csv_field(shown(cell, kind));
  if (number == nullptr) return data::csv_field(shown(cell, kind));
  return std::isfinite(*number) ? data::shortest(*number) : "";
}

/// A number as LaTeX sets it: the minus sign in mathematics, 7.51e-05 as a power of ten.
std::string latex_number(const std::string& rounded) {
  const std::size_t e = rounded.find('e');
  if (e == std::string::npos) return rounded.front() == '-' ? "$" + rounded + "$" : rounded;
  const int exponent = std::stoi(rounded.substr(e + 1));
  return fmt::format("${}\\times 10^{{{}}}$", rounded.substr(0, e), exponent);
}

std::string markdown_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      result += ' ';
      continue;
    }
    // Characters that would end the cell or start emphasis, code, links or HTML.
    if (std::string_view("\\`*_[]<|~").find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

/// Characters that have a meaning in LaTeX or are missing in its fonts.
constexpr std::array<std::pair<std::string_view, std::string_view>, 20> kLatexSigns{{
    {"\\", "\\textbackslash{}"},
    {"^", "\\textasciicircum{}"},
    {"~", "\\textasciitilde{}"},
    {"<", "\\textless{}"},
    {">", "\\textgreater{}"},
    {"&", "\\&"},
    {"%", "\\%"},
    {"$", "\\$"},
    {"#", "\\#"},
    {"_", "\\_"},
    {"{", "\\{"},
    {"}", "\\}"},
    {"*", "{*}"},  // after the end of a row, * and [ would be read as its arguments
    {"[", "{[}"},
    {"\n", " "},
    {"\r", " "},
    {"\u00B2", "$^2$"},
    {"\u03C3", "$\\sigma$"},
    {"\u03C8", "$\\psi$"},
    {"\u2212", "$-$"},
}};

std::string latex_text(const std::string& text) {
  std::string result;
  for (std::string_view rest = text; !rest.empty();) {
    const auto* const sign = std::ranges::find_if(
        kLatexSigns, [&](const auto& each) { return rest.starts_with(each.first); });
    const bool is_sign = sign != kLatexSigns.end();
    result += is_sign ? sign->second : rest.substr(0, 1);
    rest.remove_prefix(is_sign ? sign->first.size() : 1);
  }
  return result;
}

/// Stars are superscripts, as in print.
std::string latex_mark(const std::string& text) {
  const bool is_stars =
      !text.empty() && std::ranges::all_of(text, [](char each) { return each == '*'; });
  return is_stars ? fmt::format("$^{{{}}}$", text) : latex_text(text);
}

std::string latex_cell(const TableCell& cell, ColumnKind kind) {
  if (const auto* text = std::get_if<std::string>(&cell)) return latex_text(*text);
  if (const auto* marked = std::get_if<MarkedNumber>(&cell)) {
    if (!std::isfinite(marked->value)) return "";
    return latex_text(marked->before) + latex_number(rounded(marked->value, kind)) +
           latex_mark(marked->after);
  }
  const std::string text = shown(cell, kind);
  if (text.empty() || kind == ColumnKind::kP) return latex_text(text);
  return latex_number(text);
}

bool is_number(const TableColumn& column) { return column.kind != ColumnKind::kText; }

/// A title over several lines, so that a column is as wide as its numbers.
std::string latex_title(const TableColumn& column) {
  constexpr std::size_t kWidth = 9;
  const std::string& title = column.title;
  if (title.size() <= kWidth || title.find(' ') == std::string::npos) return latex_text(title);
  std::vector<std::string> lines(1);
  std::string_view rest = title;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(' '), rest.size());
    const std::string word(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!lines.back().empty() && lines.back().size() + word.size() >= kWidth) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  for (std::string& line : lines) line = latex_text(line);
  return fmt::format("\\begin{{tabular}}[b]{{@{{}}{}@{{}}}}{}\\end{{tabular}}",
                     is_number(column) ? 'r' : 'l',
                     fmt::join(lines, "\\\\"));
}

/// The cells of a row, each written by its column.
template <typename Write>
std::vector<std::string> written_row(const FormattedTable& table,
                                     const TableRow& row,
                                     const Write& write) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    texts.push_back(write(row[i], table.columns[i].kind));
  }
  return texts;
}

template <typename Write>
std::vector<std::string> titles(const FormattedTable& table, const Write& write) {
  std::vector<std::string> texts;
  for (const TableColumn& column : table.columns) texts.push_back(write(column));
  return texts;
}

std::string markdown_title(const TableColumn& column) { return markdown_text(column.title); }

std::string markdown_cell(const TableCell& cell, ColumnKind kind) {
  return markdown_text(shown_text(cell, kind));
}

/// Numbers are aligned to the right, texts to the left; sentences are wrapped.
std::string latex_alignment(const FormattedTable& table, std::size_t column) {
  constexpr std::size_t kSentence = 40;
  if (is_number(table.columns[column])) return "r";
  const bool has_sentences = std::ranges::any_of(table.rows, [column](const TableRow& row) {
    const auto* text = std::get_if<std::string>(&row[column]);
    return text != nullptr && text->size() > kSentence;
  });
  return has_sentences ? "p{4cm}" : "l";
}

/// The environment with rows of a table from begin to end.
std::string latex_tabular(const FormattedTable& table, std::size_t begin, std::size_t end) {
  // Rules need some room above the letters below them.
  const std::string strut = "\\rule{0pt}{2.5ex}";
  std::string alignment;
  for (std::size_t i = 0; i < table.columns.size(); ++i) alignment += latex_alignment(table, i);
  std::string text = fmt::format("\\begin{{tabular}}{{{}}}\n\\hline\n", alignment);
  text += strut + fmt::format("{} \\\\\n\\hline\n", fmt::join(titles(table, latex_title), " & "));
  for (std::size_t row = begin; row < end; ++row) {
    text += row == begin ? strut : "";
    text +=
        fmt::format("{} \\\\\n", fmt::join(written_row(table, table.rows[row], latex_cell), " & "));
  }
  return text + "\\hline\n\\end{tabular}\n";
}

/// Tables with many columns have a smaller font, and are fitted to the width of the text if the
/// document has the package graphicx.
std::string latex_fitted(const std::string& tabular) {
  return "\\scriptsize\n\\setlength{\\tabcolsep}{3pt}\n\\setbox0=\\hbox{" + tabular +
         "}%\n\\ifdim\\wd0>\\textwidth\n"
         "\\ifdefined\\resizebox\\resizebox{\\textwidth}{!}{\\box0}\\else\\box0\\fi\n"
         "\\else\\box0\\fi\n";
}

/// Rows of a table that fit on one page.
std::string latex_part(const FormattedTable& table, std::size_t begin, std::size_t end) {
  constexpr std::size_t kManyColumns = 8;
  const std::string tabular = latex_tabular(table, begin, end);
  std::string text = fmt::format("\\begin{{table}}\n\\caption{{{}{}}}\n",
                                 latex_text(table.caption),
                                 begin > 0 ? " (continued)" : "");
  if (begin == 0) text += fmt::format("\\label{{tab:{}}}\n", table.name);
  text += "\\par\\smallskip\n";
  text += table.columns.size() > kManyColumns ? latex_fitted(tabular) : tabular;
  return text + "\\end{table}\n";
}

}  // namespace

std::string shown_text(const TableCell& cell, ColumnKind kind) {
  if (std::holds_alternative<std::string>(cell)) return std::get<std::string>(cell);
  return with_minus_signs(shown(cell, kind));
}

std::string to_csv(const FormattedTable& table) {
  std::vector<std::string> fields;
  for (const TableColumn& column : table.columns) fields.push_back(data::csv_field(column.name));
  std::string text = fmt::format("{}\n", fmt::join(fields, ","));
  for (const TableRow& row : table.rows) {
    fields = written_row(table, row, csv_text);
    text += fmt::format("{}\n", fmt::join(fields, ","));
  }
  return text;
}

std::string to_markdown(const FormattedTable& table) {
  std::string text = fmt::format("## {}\n\n", markdown_text(table.caption));
  text += fmt::format("| {} |\n", fmt::join(titles(table, markdown_title), " | "));
  text += "|";
  for (const TableColumn& column : table.columns) text += is_number(column) ? "---:|" : "---|";
  text += "\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("| {} |\n", fmt::join(written_row(table, row, markdown_cell), " | "));
  }
  return text;
}

std::string to_latex(const FormattedTable& table) {
  constexpr std::size_t kRowsOfPage = 45;
  std::string text = latex_part(table, 0, std::min(kRowsOfPage, table.rows.size()));
  for (std::size_t begin = kRowsOfPage; begin < table.rows.size(); begin += kRowsOfPage) {
    text += latex_part(table, begin, std::min(begin + kRowsOfPage, table.rows.size()));
  }
  return text;
}

}  // namespace silvafit::study
