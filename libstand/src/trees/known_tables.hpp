// SPDX-License-Identifier: MIT
// Tables of national inventories and networks of plots, whose columns are described by
// models/sources/*.json.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/stand/tree_status.hpp"

namespace silvafit::stand {

/// Columns by which a table is known; upper and lower case are equal.
struct KnownHeader {
  std::vector<std::string> all{};
  std::vector<std::string> some{};
  std::size_t at_least = 0;  ///< of `some`
};

/// A table with documented columns, units and codes.
struct KnownTable {
  std::string title{};           ///< "FIA's TREE, in inches and feet"
  bool has_fia_species = false;  ///< numbers of species are codes of FIA
  std::vector<KnownHeader> recognized{};
  /// Sources of plot, location (of a plot at all its visits), tree, species, measures, year, date
  /// and trees_per_ha; the first whose columns exist is used. In labels of several columns, those
  /// with `?` may be missing.
  std::map<std::string, std::vector<std::string>> columns{};
  std::map<std::string, std::string> units{};  ///< by column
  /// Columns of the status; of several the first that is not missing holds.
  std::vector<std::string> status_columns{};
  std::map<std::string, TreeStatus> status{};  ///< by code
  std::optional<TreeStatus> other_status{};    ///< of all other codes
  /// Headers of tables of plots, and their columns of the label.
  std::vector<std::pair<KnownHeader, std::string>> plots{};
};

/// The texts of models/sources, which the build puts into a source file.
const std::vector<std::string_view>& known_table_texts();

/// The known table with this header; null if it is none.
const KnownTable* known_table(const std::vector<std::string>& header);

/// The sources of the standard columns of such a table, with the names of the header; of a table
/// that is not known none.
/// \param by_location  whether rows of several visits belong to one plot
std::vector<ColumnMapping> known_columns(const std::vector<std::string>& header, bool by_location);

/// The unit of a column of a known table; empty if it is not given.
std::string_view known_unit(const std::string& column, const std::vector<std::string>& header);

/// The column of the status of a known table, or first() of several, which prepared_table() makes.
std::optional<std::string> known_status_column(const std::vector<std::string>& header);

/// The known table whose column of the status this is; null if there is none. A column called
/// status is one of many, unless the header is that of a known table.
const KnownTable* known_status_table(std::string_view column,
                                     const std::vector<std::string>& header);

/// The meaning of a code in the column of the status of a known table; none if it has no meaning.
std::optional<TreeStatus> known_status(const KnownTable& table, std::string_view code);

/// The column of labels of a known table of plots.
std::optional<std::string> known_plot_column(const std::vector<std::string>& header);

}  // namespace silvafit::stand
