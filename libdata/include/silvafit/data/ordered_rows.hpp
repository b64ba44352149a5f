// SPDX-License-Identifier: MIT
// Rows of a result in the order of the file that they are computed from.
#pragma once

#include <cstddef>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "silvafit/base/external_sort.hpp"

namespace silvafit::data {

/// Writes rows that were computed in another order than that of their lines in a file, such as plot
/// by plot, in the order of these lines. Rows with one line keep their order. Memory: as
/// ExternalSort.
class OrderedRows {
 public:
  /// \param sorts  false: the rows come in order, and are written as they come
  OrderedRows(std::ostream& stream, bool sorts);

  /// \param text  with its line end
  void add(std::size_t line, std::string_view text);
  /// Writes what is not written yet.
  void finish();

 private:
  std::ostream& stream_;
  std::optional<ExternalSort> sort_{};
  std::string buffer_{};

  void write(std::string_view text);
  void flush();
};

}  // namespace silvafit::data
