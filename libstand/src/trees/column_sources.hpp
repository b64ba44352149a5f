// SPDX-License-Identifier: MIT
// Parts of the search for the columns of a file.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {

/// The position of a name in a header; none if it has no such column.
std::optional<std::size_t> field_named(std::string_view name,
                                       const std::vector<std::string>& header);

/// Whether the user says that the table has no such column: x=NA, unless NA is a column.
bool is_no_column(const ColumnMapping& mapping, const std::vector<std::string>& header);

/// The unit of a column, by its header, by a row of units or by the description of the table.
std::optional<LengthUnit> unit_of_field(std::size_t field,
                                        const std::vector<std::string>& header,
                                        const std::vector<std::string>& units);

/// The degrees of another unit of angles of a column, by its header or a row of units.
std::optional<double> degrees_of_field(std::size_t field,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::string>& units);

/// The position in a header of a name in upper or lower case.
std::optional<std::size_t> field_in_any_case(std::string_view name,
                                             const std::vector<std::string>& header);

/// Where a table has a column: as mapped, a measure in our unit, under a usual name, or under its
/// own; none if it does not.
/// \param units   of each column, from a row below the header
/// \param mapped  by the user
/// \throws as usual_columns()
std::optional<ColumnMapping> source_of(const std::string& name,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::string>& units,
                                       const std::vector<ColumnMapping>& mapped,
                                       const std::string& file);

/// Times, stands and statuses are columns, because expressions make numbers.
/// \throws UsageError if the source is not a column
void require_column(const ColumnMapping& mapping,
                    const std::vector<std::string>& header,
                    const std::string& file);

/// The numbers of a standard measure, in its unit. The codes of missing values are those of the
/// file, before a conversion; 0 is one where the measure cannot be 0. \param table  with the
/// columns of the reference only \param found  called with the column and the text of each code
std::vector<double> measured_values(
    std::string_view name,
    const data::ColumnReference& reference,
    data::Table table,
    const std::function<void(const std::string& column, const std::string& code)>& found = {});

}  // namespace silvafit::stand
