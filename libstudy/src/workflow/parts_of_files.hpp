// SPDX-License-Identifier: MIT
// Opens the files of a command to be read in parts.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table_parts.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// Opens a CSV file to read it in parts.
/// \param group  gets the header and returns the name of the column whose groups stay whole, if
///               the file has such a column; empty: rows are independent
/// \param rows   of a part, at least
/// \throws UsageError if the source is no CSV file; else as data::TableParts
data::TableParts table_parts(
    const data::TableSource& source,
    const ReadingSettings& settings,
    const std::function<std::string(const std::vector<std::string>&)>& group,
    std::size_t rows = data::TablePartsOptions{}.rows);

}  // namespace silvafit::study
