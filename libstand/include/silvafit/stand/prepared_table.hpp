// SPDX-License-Identifier: MIT
// Tables of trees before they are read: rows that are chosen, visits in columns of their own, and
// columns of texts that are made of others.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

struct PreparedTable {
  data::TableSource table{};  ///< the source itself, if there is nothing to do
  std::size_t made = 0;       ///< columns of texts, the last ones
  std::string note{};         ///< on what was done; empty: nothing
};

/// Whether the options make columns: of visits, or of texts.
bool makes_columns(const InventoryOptions& options,
                   const std::vector<std::string>& header,
                   const std::string& file);

/// The table with the chosen rows and the made columns, by `where`, `visits`, `columns`, `missing`
/// and `fill_down` of the options; a text formula is a column with its text as
/// the name. Rows keep their lines in the file.
/// \param is_part  of a file, whose rows may all be left out
/// \throws InputError if a name is not a column, or no row is left; UsageError if visits or texts
///   cannot be read
PreparedTable prepared_table(const data::TableSource& source,
                             const InventoryOptions& options,
                             bool is_part = false);

/// The fields that `fill_down` means, by position in the header; its names are those of the file,
/// or standard ones.
/// \throws UsageError if there is no such column
std::vector<std::size_t> filled_fields(const InventoryOptions& options,
                                       const std::vector<std::string>& header,
                                       const std::string& file);

}  // namespace silvafit::stand
