// SPDX-License-Identifier: MIT
// How each column of a table of trees is understood, and what commands lack.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/prepared_table.hpp"

namespace silvafit::stand {

/// A column of a table.
struct DescribedColumn {
  std::string name{};     ///< of the file
  std::string read_as{};  ///< standard columns that are made of it, "dbh"; empty: none
  std::string source{};   ///< the formula, if it is not the column itself: `BHD [mm]`/10
  std::string unit{};     ///< of the standard column: cm or m
  bool is_numeric = false;
  std::size_t missing = 0;  ///< rows
  double lowest = 0.0;      ///< of numbers, in the standard unit; NaN if there are none
  double highest = 0.0;
  std::size_t impossible = 0;           ///< numbers out of the range of the standard column
  std::size_t different = 0;            ///< texts
  std::vector<std::string> examples{};  ///< the first of these
};

/// What a command needs and the table lacks.
struct LackingCommand {
  std::string command{};
  std::vector<std::string> lacks{};  ///< standard columns
};

struct TableDescription {
  std::string file{};
  std::size_t rows = 0;
  std::vector<DescribedColumn> columns{};
  std::vector<std::string>
      notes{};  ///< layout, codes, ambiguous columns, columns that may be meant
  std::vector<LackingCommand> commands{};  ///< all; nothing is lacking if the list is empty
};

/// Reads a whole table and describes it. Columns that could be two standard ones are noted.
/// \throws as data::read_csv_table and prepared_table
TableDescription describe_columns(const data::TableSource& source, const InventoryOptions& options);

/// Columns of a header whose names contain a usual name of a standard column, and that have no
/// other meaning: DBH.2018 for dbh.
std::vector<std::string> likely_columns(std::string_view name,
                                        const std::vector<std::string>& header);

/// "no column dbh (diameter at breast height in cm) was found; ...", with the columns that may be
/// meant and the remedy.
std::string no_standard_column(const TreeColumn& column, const std::vector<std::string>& header);

}  // namespace silvafit::stand
