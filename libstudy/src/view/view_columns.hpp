// SPDX-License-Identifier: MIT
// Columns of a table that the 3D page uses for colors only.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// A column for colors: numbers, or texts.
struct ViewColumn {
  std::string name{};
  std::vector<std::string> texts{};  ///< distinct texts by falling number of trees; empty: numbers
  std::vector<double> values{};      ///< of the trees; indices of texts; NaN if missing
};

/// The columns that have no colors of their own: at most 30, in the order of the table. Columns
/// with a single value, and of texts those with more than 40 (names, remarks), are left out.
/// \param used  other names of the columns of trees, as in ViewOptions
/// \param rows  of the trees
std::vector<ViewColumn> color_columns(const data::Table& table,
                                      const std::map<std::string, std::string>& used,
                                      std::span<const std::size_t> rows);

}  // namespace silvafit::study
