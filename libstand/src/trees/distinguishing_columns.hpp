// SPDX-License-Identifier: MIT
// Columns that nothing reads and that tell apart what has one label: visits, subplots, farms.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::stand {

/// Rows of the table with one label, which some column may distinguish, in parts of several rows.
struct LabelParts {
  std::string label{};
  std::vector<std::vector<std::size_t>> rows{};  ///< of each part, by position in the table, from 0
};

/// A column with one value in each part, and another one in each part of a label.
struct DistinguishingColumn {
  std::size_t field = 0;
  std::vector<std::vector<std::string>> values{};  ///< by label and part
  std::size_t distinct = 0;                        ///< number of different values
};

/// The columns that distinguish the parts of all labels, that with the fewest values first. Reads
/// the table a second time.
/// \param fields  the columns to try
/// \returns nothing for a pipe, which cannot be read again
std::vector<DistinguishingColumn> distinguishing_columns(const data::TableSource& source,
                                                         const std::vector<std::string>& missing,
                                                         const std::vector<std::size_t>& fields,
                                                         const std::vector<LabelParts>& labels);

}  // namespace silvafit::stand
