// SPDX-License-Identifier: MIT
// Formulas whose values are texts, such as `genus + " " + epithet`.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// The parts of a text between a sign, without blanks around them. Signs within parentheses, double
/// quotes and backquotes do not separate.
std::vector<std::string_view> split_at(std::string_view text, char sign);

/// A formula of columns and texts in double quotes: `a + " " + b` joins texts, `first(a, b)` is the
/// first that is not missing, `ifelse(CONDITION, a, b)` one of two; NA is a missing value. A joined
/// text is missing if a column in it is.
class TextFormula {
 public:
  /// None if the text is a column, or has neither a quoted text nor first() where a value stands.
  /// \param columns  names that it may use
  /// \param file     for messages
  /// \throws InputError if it has, and a name is not a column; UsageError if it cannot be read
  static std::optional<TextFormula> parse(std::string_view text,
                                          std::span<const std::string> columns,
                                          const std::string& file);

  /// The columns whose texts are its values.
  std::vector<std::string> columns() const;
  /// All columns that it reads, those of conditions, too.
  std::vector<std::string> all_columns() const;

  /// (N) the values for the rows of a table.
  /// \param is_missing  whether a text is a code for a missing value
  TextColumn values(const Table& table,
                    const std::function<bool(std::string_view)>& is_missing) const;

  struct Node;

 private:
  explicit TextFormula(std::shared_ptr<const Node> node) : node_(std::move(node)) {}

  std::shared_ptr<const Node> node_;
};

}  // namespace silvafit::data
