// SPDX-License-Identifier: MIT
// Columns that are not read although they may hold what a reader looks for.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_columns.hpp"

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
  explicit StatusWords(std::string column) : column_(std::move(column)) {}
  /// The value if it has such words, else null; to be counted if its tree is used as a living one.
  /// Valid as long as this object.
  const std::string* find(std::string_view value);
  void count(const std::string& value, std::size_t rows = 1);
  void add(std::string_view value, std::size_t rows = 1) {
    if (const std::string* const found = find(value)) count(*found, rows);
  }
  void add(const data::TextColumn& values);
  /// Empty if there are none.
  std::string note() const;

 private:
  bool is_given_up() const;

  std::string column_{};
  std::map<std::string, bool, std::less<>> values_{};  ///< whether they have such words
  std::size_t numbers_ = 0;                            ///< of them
  std::size_t rows_ = 0;
  std::string first_{};
};

}  // namespace silvafit::stand
