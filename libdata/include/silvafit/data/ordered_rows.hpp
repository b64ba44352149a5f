// SPDX-License-Identifier: MIT
// Writes rows of results in the order of the input file.
#pragma once

#include <cstddef>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "silvafit/base/external_sort.hpp"

namespace silvafit::data {

/// Writes rows that are computed in another order, such as plot by plot, in the order of their
/// lines in the input file. Rows of the same line keep their order. Memory: that of ExternalSort.
class OrderedRows {
 public:
  /// \param sorts  false if the rows are added in order, so that they can be written at once
  OrderedRows(std::ostream& stream, bool sorts);

  /// \param text  including the line end
  void add(std::size_t line, std::string_view text);
  /// Writes the remaining rows.
  void finish();

 private:
  std::ostream& stream_;
  std::optional<ExternalSort> sort_{};
  std::string buffer_{};

  void write(std::string_view text);
  void flush();
};

}  // namespace silvafit::data
