// SPDX-License-Identifier: MIT
// Lines and numbers of text tables; unknown values are dashes.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/fit/fit_statistics.hpp"

namespace silvafit::fit {

/// Appends formatted text.
template <typename... Values>
void append(std::string& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
}

/// Rows of cells; the first column is as wide as its widest cell.
class TextTable {
 public:
  /// \param least   width of the first column, at least
  /// \param widths  of the other columns, negative for cells on the left; 0 for a text at the end
  TextTable(std::size_t least, std::vector<int> widths)
      : first_(least), widths_(std::move(widths)) {}

  /// With any number of cells up to that of the columns.
  void add(std::vector<std::string> cells) {
    first_ = std::max(first_, cells.front().size());
    rows_.push_back(std::move(cells));
  }

  void append_to(std::string& text) const {
    for (const std::vector<std::string>& row : rows_) {
      append(text, "{:<{}}", row.front(), first_);
      for (std::size_t k = 1; k < row.size(); ++k) {
        const int width = widths_[k - 1];
        if (width > 0) append(text, " {:>{}}", row[k], width);
        if (width < 0) append(text, " {:<{}}", row[k], -width);
        if (width == 0 && !row[k].empty()) append(text, "  {}", row[k]);
      }
      text += '\n';
    }
  }

 private:
  std::size_t first_;
  std::vector<int> widths_;
  std::vector<std::vector<std::string>> rows_;
};

/// With a number of significant digits.
inline std::string significant(double value, int digits = 6) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}g}", value, digits);
}

/// With a number of decimals.
inline std::string decimals(double value, int digits = 4) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

/// A row of goodness of fit.
inline std::vector<std::string> statistics_cells(std::string name, const FitStatistics& values) {
  return {std::move(name),
          decimals(values.r2),
          significant(values.rmse),
          significant(values.mean_error, 3),
          significant(values.mae)};
}

}  // namespace silvafit::fit
