// SPDX-License-Identifier: MIT
#include "study/formatted_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "silvafit/data/csv.hpp"

namespace silvafit::study {
namespace {

std::string csv_text(const TableCell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return data::csv_field(*text);
  const auto* number = std::get_if<double>(&cell);
  return number != nullptr && std::isfinite(*number) ? data::shortest(*number) : "";
}

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

std::string shown(const TableCell& cell, ColumnKind kind) {
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  const auto* number = std::get_if<double>(&cell);
  return number != nullptr && std::isfinite(*number) ? rounded(*number, kind) : "";
}

std::string markdown_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\n' || c == '\r') {
      result += ' ';
      continue;
    }
    // Characters that would end the cell or begin emphasis, code, links or HTML.
    if (std::string_view("\\`*_[]<|~").find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

std::string latex_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '\\':
        result += "\\textbackslash{}";
        break;
      case '^':
        result += "\\textasciicircum{}";
        break;
      case '~':
        result += "\\textasciitilde{}";
        break;
      case '<':
        result += "\\textless{}";
        break;
      case '>':
        result += "\\textgreater{}";
        break;
      case '&':
      case '%':
      case '$':
      case '#':
      case '_':
      case '{':
      case '}':
        result += '\\';
        result += c;
        break;
      default:
        result += c;
    }
  }
  return result;
}

bool is_number(const TableColumn& column) { return column.kind != ColumnKind::kText; }

/// The cells of a row as people read them, each made safe for its format.
template <typename Escape>
std::vector<std::string> shown_row(const FormattedTable& table,
                                   const TableRow& row,
                                   Escape escape) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    texts.push_back(escape(shown(row[i], table.columns[i].kind)));
  }
  return texts;
}

template <typename Escape>
std::vector<std::string> titles(const FormattedTable& table, Escape escape) {
  std::vector<std::string> texts;
  for (const TableColumn& column : table.columns) texts.push_back(escape(column.title));
  return texts;
}

}  // namespace

std::string to_csv(const FormattedTable& table) {
  std::vector<std::string> fields;
  for (const TableColumn& column : table.columns) fields.push_back(data::csv_field(column.name));
  std::string text = fmt::format("{}\n", fmt::join(fields, ","));
  for (const TableRow& row : table.rows) {
    fields.clear();
    for (const TableCell& cell : row) fields.push_back(csv_text(cell));
    text += fmt::format("{}\n", fmt::join(fields, ","));
  }
  return text;
}

std::string to_markdown(const FormattedTable& table) {
  std::string text = fmt::format("## {}\n\n", markdown_text(table.caption));
  text += fmt::format("| {} |\n", fmt::join(titles(table, markdown_text), " | "));
  text += "|";
  for (const TableColumn& column : table.columns) text += is_number(column) ? "---:|" : "---|";
  text += "\n";
  for (const TableRow& row : table.rows) {
    text += fmt::format("| {} |\n", fmt::join(shown_row(table, row, markdown_text), " | "));
  }
  return text;
}

std::string to_latex(const FormattedTable& table) {
  std::string alignment;
  for (const TableColumn& column : table.columns) alignment += is_number(column) ? 'r' : 'l';
  std::string text = fmt::format(
      "\\begin{{table}}\n\\caption{{{}}}\n\\label{{tab:{}}}\n\\begin{{tabular}}{{{}}}\n\\hline\n",
      latex_text(table.caption),
      table.name,
      alignment);
  text += fmt::format("{} \\\\\n\\hline\n", fmt::join(titles(table, latex_text), " & "));
  for (const TableRow& row : table.rows) {
    text += fmt::format("{} \\\\\n", fmt::join(shown_row(table, row, latex_text), " & "));
  }
  return text + "\\hline\n\\end{tabular}\n\\end{table}\n";
}

}  // namespace silvafit::study
