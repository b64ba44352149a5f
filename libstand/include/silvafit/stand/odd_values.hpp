// SPDX-License-Identifier: MIT
// Single sizes and positions of trees that are likely slips.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/size_units.hpp"

namespace silvafit::stand {

/// Single values that no tree reaches, or that are far beyond all others of their column, of a
/// table or of its parts one after another.
class OddValues {
 public:
  /// \param name      of a measure of tree_columns(); those without a usual limit are not judged
  /// \param values    one a row, NaN where missing
  /// \param place_of  of a row
  void add(std::string_view name, std::span<const double> values, const PlaceOfRow& place_of);
  /// One a value or column, with its place.
  std::vector<std::string> notes() const;

 private:
  struct Beyond {
    std::string first{};  ///< place and value
    std::size_t count = 0;
    std::size_t values = 0;
    double largest = 0.0;
    double next = 0.0;  ///< the largest of the others
    Place place{};      ///< of the largest
  };
  std::map<std::size_t, Beyond> beyond_{};  ///< of columns, by their position in tree_columns()
};

}  // namespace silvafit::stand
