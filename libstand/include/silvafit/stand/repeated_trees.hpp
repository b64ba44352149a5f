// SPDX-License-Identifier: MIT
// Several rows with the same plot and tree.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// A row that has the plot and tree of an earlier one.
struct RepeatedTree {
  std::size_t row = 0;
  std::size_t first_row = 0;        ///< if it is the same tree, the first row of that tree
  bool is_same_tree = false;        ///< a copy, or a repeated measurement
  bool is_later = false;            ///< a repeated measurement: the time is another one
  bool is_same_place = false;       ///< another tree, or another stem of the same stool
  bool is_of_unknown_time = false;  ///< another tree, or the same one: time and place are unknown
  std::string new_id{};             ///< of another tree: an id of its own, such as `64#2`
};

/// Classifies each row that has the plot and tree of an earlier one. It is the same tree if both
/// rows have the same position and dbh or, without a position, the same measures; or if they have
/// different times and their distance is at most the error of a second survey, 1 m. Otherwise two
/// trees (or two stems of one stool) have the same number.
/// \param times  (N) when each row was measured, missing where unknown; empty: always unknown
/// \return       by ascending row
std::vector<RepeatedTree> repeated_trees(const Inventory& inventory, const data::TextColumn& times);

}  // namespace silvafit::stand
