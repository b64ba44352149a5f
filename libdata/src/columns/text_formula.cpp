// SPDX-License-Identifier: MIT
#include "silvafit/data/text_formula.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::data {

struct TextFormula::Node {
  enum class Kind { kText, kNothing, kColumn, kJoin, kFirst, kChoice } kind = Kind::kText;
  std::string text{};  ///< a text, the name of a column, or a condition
  std::vector<std::shared_ptr<const Node>> parts{};
};

namespace {

using Node = TextFormula::Node;
using Kind = Node::Kind;
using Parts = std::vector<std::string_view>;

/// The text between a function's parentheses, if the whole text is one call of it.
std::optional<std::string_view> arguments_of(std::string_view text, std::string_view function) {
  if (!text.starts_with(function) || !text.ends_with(')')) return std::nullopt;
  std::string_view rest = trimmed(text.substr(function.size()));
  if (!rest.starts_with('(')) return std::nullopt;
  int depth = 0;
  for (std::size_t i = 0; i + 1 < rest.size(); ++i) {
    depth += rest[i] == '(' ? 1 : rest[i] == ')' ? -1 : 0;
    if (depth == 0) return std::nullopt;
  }
  return rest.substr(1, rest.size() - 2);
}

bool is_quoted(std::string_view text, char quote) {
  return text.size() >= 2 && text.front() == quote && text.find(quote, 1) == text.size() - 1;
}

class Parser {
 public:
  explicit Parser(std::span<const std::string> columns) : columns_(columns) {}

  std::shared_ptr<const Node> parse(std::string_view text);

  bool has_texts() const { return has_texts_; }
  /// The first part that is no value; empty if there is none.
  const std::string& unknown() const { return unknown_; }

 private:
  bool is_column(std::string_view name) const {
    return std::ranges::find(columns_, name) != columns_.end();
  }
  std::shared_ptr<const Node> node(Kind kind, const Parts& parts, std::string_view text = {});
  std::shared_ptr<const Node> value(std::string_view text);

  std::span<const std::string> columns_;
  bool has_texts_ = false;
  std::string unknown_{};
};

std::shared_ptr<const Node> Parser::node(Kind kind, const Parts& parts, std::string_view text) {
  auto made = std::make_shared<Node>();
  made->kind = kind;
  made->text = text;
  for (const std::string_view part : parts) made->parts.push_back(parse(part));
  return made;
}

std::shared_ptr<const Node> Parser::value(std::string_view text) {
  double ignored = 0.0;
  if (is_quoted(text, '"')) {
    has_texts_ = true;
    return node(Kind::kText, {}, text.substr(1, text.size() - 2));
  }
  if (is_quoted(text, '`')) text = text.substr(1, text.size() - 2);
  if (is_column(text)) return node(Kind::kColumn, {}, text);
  if (text == "NA") return node(Kind::kNothing, {});
  if (parse_number(text, ignored)) return node(Kind::kText, {}, text);
  if (unknown_.empty()) unknown_ = text;
  return node(Kind::kNothing, {});
}

std::shared_ptr<const Node> Parser::parse(std::string_view text) {
  if (is_column(text)) return node(Kind::kColumn, {}, text);
  const Parts summands = split_at(text, '+');
  if (summands.size() > 1) return node(Kind::kJoin, summands);
  if (const auto arguments = arguments_of(text, "first")) {
    has_texts_ = true;
    return node(Kind::kFirst, split_at(*arguments, ','));
  }
  if (const auto arguments = arguments_of(text, "ifelse")) {
    Parts parts = split_at(*arguments, ',');
    if (parts.size() == 3) return node(Kind::kChoice, {parts[1], parts[2]}, parts[0]);
  }
  if (const auto inside = arguments_of(text, "")) return parse(trimmed(*inside));
  return value(text);
}

void add(std::string name, std::vector<std::string>& names) {
  if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
}

void add_columns(const Node& node, bool with_conditions, std::vector<std::string>& names) {
  if (node.kind == Kind::kColumn) add(node.text, names);
  if (node.kind == Kind::kChoice && with_conditions) {
    for (std::string& name : columns_of(Expression::parse(node.text))) add(std::move(name), names);
  }
  for (const auto& part : node.parts) add_columns(*part, with_conditions, names);
}

using Cell = std::optional<std::string>;

/// The values of a part for all rows.
std::vector<Cell> cells_of(const Node& node,
                           const Table& table,
                           const std::function<bool(std::string_view)>& is_missing) {
  std::vector<Cell> cells(table.rows());
  if (node.kind == Kind::kText) std::ranges::fill(cells, node.text);
  if (node.kind == Kind::kColumn) {
    const TextColumn labels = table.labels(node.text);
    for (std::size_t row = 0; row < cells.size(); ++row) {
      if (!labels.is_missing(row) && !is_missing(labels[row])) cells[row] = labels[row];
    }
  }
  std::vector<std::vector<Cell>> parts;
  for (const auto& part : node.parts) parts.push_back(cells_of(*part, table, is_missing));
  const std::vector<double> holds =
      node.kind == Kind::kChoice ? checked_values(node.text, table) : std::vector<double>();
  for (std::size_t row = 0; row < cells.size() && !parts.empty(); ++row) {
    if (node.kind == Kind::kChoice) {
      if (!std::isnan(holds[row])) cells[row] = parts[holds[row] != 0.0 ? 0 : 1][row];
      continue;
    }
    if (node.kind == Kind::kJoin) cells[row] = std::string();
    for (const std::vector<Cell>& part : parts) {
      if (node.kind == Kind::kFirst && !cells[row]) cells[row] = part[row];
      if (node.kind != Kind::kJoin || !cells[row]) continue;
      part[row] ? void(*cells[row] += *part[row]) : cells[row].reset();
    }
  }
  return cells;
}

}  // namespace

std::vector<std::string_view> split_at(std::string_view text, char sign) {
  Parts parts;
  int depth = 0;
  char quote = '\0';  // the one that is open
  std::size_t begin = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quote == '\0' && (text[i] == '"' || text[i] == '`')) {
      quote = text[i];
    } else if (text[i] == quote) {
      quote = '\0';
    }
    if (quote != '\0') continue;
    if (text[i] == '(') ++depth;
    if (text[i] == ')') --depth;
    if (text[i] != sign || depth > 0) continue;
    parts.push_back(trimmed(text.substr(begin, i - begin)));
    begin = i + 1;
  }
  parts.push_back(trimmed(text.substr(begin)));
  return parts;
}

std::optional<TextFormula> TextFormula::parse(std::string_view text,
                                              std::span<const std::string> columns,
                                              const std::string& file) {
  if (std::ranges::find(columns, text) != columns.end()) return std::nullopt;
  Parser parser(columns);
  const std::shared_ptr<const Node> node = parser.parse(trimmed(text));
  const std::string& unknown = parser.unknown();
  if (unknown.find("first(") != std::string::npos) {
    throw UsageError(
        fmt::format("'{}' cannot be read: first(A, B) is a value of its own, or stands "
                    "in a joined text; convert units in the file",
                    text),
        {.file = file, .column = "`columns`"});
  }
  if (!parser.has_texts()) return std::nullopt;
  if (unknown.empty()) return TextFormula(node);
  throw InputError(
      fmt::format("unknown column '{}' in {} (put text in double quotes); available: {}",
                  unknown,
                  text,
                  list_of(columns)),
      {.file = file});
}

std::vector<std::string> TextFormula::columns() const {
  std::vector<std::string> names;
  add_columns(*node_, false, names);
  return names;
}

std::vector<std::string> TextFormula::all_columns() const {
  std::vector<std::string> names;
  add_columns(*node_, true, names);
  return names;
}

TextColumn TextFormula::values(const Table& table,
                               const std::function<bool(std::string_view)>& is_missing) const {
  TextColumn column;
  for (const Cell& cell : cells_of(*node_, table, is_missing)) {
    cell ? column.append(*cell) : column.append_missing();
  }
  return column;
}

}  // namespace silvafit::data
