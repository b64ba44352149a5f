// SPDX-License-Identifier: MIT
// A sheet of a workbook as delimited text.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gdal/dataset.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::source {

/// The cells of a sheet as the sheet shows them, row n in line n.
/// \param notes  gets the notes for the user
std::shared_ptr<const data::TableText> text_of_sheet(const Dataset& workbook,
                                                     OGRLayer& sheet,
                                                     std::vector<std::string>& notes);

}  // namespace silvafit::source
