// SPDX-License-Identifier: MIT
// Tables of trees before they are read: rows that are chosen, visits in columns of their own, and
// columns of texts that are made of others.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/stand/tree_columns.hpp"

namespace silvafit::stand {

/// How the rows of a table are prepared.
struct RowPreparation {
  /// Condition for the rows to use, of columns of the file and standard names; empty: all rows.
  std::string where{};
  /// `dbh=DBH_{year}`: columns of one measure at several times, which become a row each with the
  /// columns `year` and `dbh`. What stands at {} begins with a digit.
  std::vector<ColumnMapping> visits{};
  std::vector<ColumnMapping> columns{};  ///< sources may be a data::TextFormula
  std::vector<std::string> missing{};    ///< further codes for missing values
  std::vector<std::string> fill_down{};  ///< columns whose empty fields have the value above

  /// Whether it changes the columns of a table.
  bool makes_columns(const std::vector<std::string>& header, const std::string& file) const;
};

struct PreparedTable {
  data::TableSource table{};  ///< the source itself, if there is nothing to do
  std::size_t made = 0;       ///< columns of texts, the last ones
  std::string note{};         ///< on what was done; empty: nothing
};

/// The table with the chosen rows and the made columns; a text formula is a column with its text as
/// the name. Rows keep their lines in the file.
/// \param is_part  of a file, whose rows may all be left out
/// \throws InputError if a name is not a column, or no row is left; UsageError if visits or texts
///   cannot be read
PreparedTable prepared_table(const data::TableSource& source,
                             const RowPreparation& preparation,
                             bool is_part = false);

/// The fields that are to be filled down, by position in the header.
/// \param names  as in the file, or standard ones
/// \throws UsageError if there is no such column
std::vector<std::size_t> filled_fields(const std::vector<std::string>& names,
                                       const std::vector<std::string>& header,
                                       const std::vector<ColumnMapping>& columns,
                                       const std::string& file);

}  // namespace silvafit::stand
