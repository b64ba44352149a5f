// SPDX-License-Identifier: MIT
// The columns of a layer, read through its Arrow stream.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "silvafit/data/table.hpp"

class OGRLayer;

namespace silvafit::source {

struct LayerColumn {
  std::string name{};
  std::variant<std::vector<double>, data::TextColumn> values{};
};

struct LayerColumns {
  std::size_t rows = 0;
  std::vector<LayerColumn> columns{};
  std::vector<std::string> unread{};  ///< columns of binary values and lists
  /// Columns of dates with days up to 1970-01-01, which GDAL 3.6 rounds to the day after.
  std::vector<std::string> early_dates{};
};

/// Takes the geometry of the next row as well-known binary; empty where it is missing.
using GeometrySink = std::function<void(std::span<const unsigned char> wkb)>;

/// Checks what was read after each batch: rows so far, and columns.
using BatchCheck = std::function<void(std::size_t rows, std::size_t columns)>;

/// Reads all rows of a layer. Logical values become 1 and 0; dates and times become texts as ISO
/// 8601 has them; a column with whole numbers that no double represents becomes text.
/// \param row_id  name of the column of row ids, if it is to be read
/// \param check   throws if the rows so far are too many, or must not be used
/// \throws InputError with the place if reading fails
LayerColumns read_columns(OGRLayer& layer,
                          const std::string& row_id,
                          const GeometrySink& geometry,
                          const BatchCheck& check,
                          const std::string& file);

}  // namespace silvafit::source
