// SPDX-License-Identifier: MIT
// Columns that are not read although they may hold what a reader looks for.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/stand/tree_status.hpp"

namespace silvafit::stand {

/// The note on columns that are not read but have the name of one that is: with a number, as those
/// of further visits (`dbh2`, `DBH 2022`), or crown radii between the four directions (`cr_ne`).
/// \param mapped  by the user
/// \return empty if there are none
std::string describe_unread_columns(const std::vector<std::string>& header,
                                    const std::vector<ColumnMapping>& mapped,
                                    const std::string& file);

/// The fields of stands, clusters and other units of several plots, by their usual names.
std::vector<std::size_t> fields_of_units(const std::vector<std::string>& header);

/// Counts words of dead or cut trees in a column that is not read as their status.
class StatusWords {
 public:
  struct Value {
    bool is_gone = false;      ///< it has such words, or answers a header that has
    std::size_t with_dbh = 0;  ///< rows of trees that are used as living ones
    std::size_t without_dbh = 0;
  };
  using Entry = std::pair<const std::string, Value>;

  explicit StatusWords(std::string column);
  /// A value, to be counted if its tree is used as a living one; null if it is empty, or there are
  /// too many. Valid as long as this object.
  Entry* find(std::string_view value);
  void count(Entry& entry, bool has_dbh = true, std::size_t rows = 1);
  void add(std::string_view value, std::size_t rows = 1) {
    if (Entry* const found = find(value)) count(*found, true, rows);
  }
  void add(const data::TextColumn& values);
  /// Empty if there are none.
  std::string note() const;
  /// The note on values of trees without a dbh that no tree with one has; empty if less than half
  /// of these trees have such values.
  std::string note_without_dbh(std::size_t trees) const;

 private:
  bool is_given_up() const;

  std::string column_{};
  std::map<std::string, Value, std::less<>> values_{};
  std::optional<TreeStatus> if_true_{};  ///< by the header
  std::size_t others_ = 0;               ///< values that are no answers
  std::size_t numbers_ = 0;              ///< of them
  std::size_t rows_ = 0;
  std::string first_{};
};

}  // namespace silvafit::stand
