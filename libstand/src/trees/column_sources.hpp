// SPDX-License-Identifier: MIT
// Parts of the search for the columns of a file.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/tree_columns.hpp"

namespace silvafit::stand {

/// The position in a header of a name in upper or lower case.
std::optional<std::size_t> field_in_any_case(std::string_view name,
                                             const std::vector<std::string>& header);

/// Times, stands and statuses are columns, because expressions make numbers.
/// \throws UsageError if the source is not a column
void require_column(const ColumnMapping& mapping,
                    const std::vector<std::string>& header,
                    const std::string& file);

}  // namespace silvafit::stand
