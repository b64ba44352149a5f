// SPDX-License-Identifier: MIT
// Sizes of trees in a table that has columns of any names.
#pragma once

#include <list>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/size_units.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {

struct TableSizes {
  std::vector<stand::SizeColumn> columns{};
  std::list<std::vector<double>> values{};
};

/// The sizes of trees in a table; none without dbh: only tables with dbh are of trees for certain,
/// and `h` may be anything in others.
/// \param mapped       by the user, from the columns of the table
/// \param usual        columns that the table has under our names, too, for messages
/// \param is_computed  whether the table has the mapped columns, by our names
TableSizes sizes_in(const data::Table& table,
                    const std::vector<stand::ColumnMapping>& mapped,
                    const std::vector<stand::ColumnMapping>& usual,
                    bool is_computed);

/// Checks a table, or one part of it after another. Units are those of the first part, and odd
/// values may be anywhere.
/// \param notes  receives those on odd values of all parts so far
/// \throws InputError if a column or a plot has another unit, unless units are trusted
void check_sizes(const data::Table& table,
                 const TableSizes& sizes,
                 bool trust_units,
                 ReadingState& state,
                 std::vector<std::string>& notes);

}  // namespace silvafit::study
