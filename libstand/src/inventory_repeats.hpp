// SPDX-License-Identifier: MIT
// Several rows with the same plot and tree.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// A row that has the plot and tree of an earlier one.
struct RepeatedTree {
  std::size_t row = 0;
  std::size_t first_row = 0;        ///< if it is the same tree, the first row of that tree
  bool is_same_tree = false;        ///< the row repeats the same tree
  bool is_later = false;            ///< and was measured at another time
  bool is_same_place = false;       ///< another tree, or another stem of the same stool
  bool is_of_unknown_time = false;  ///< another tree, or the same: neither place nor time tells
  std::string new_id{};             ///< for another tree: an id of its own, such as `64#2`
};

/// Rows by ascending number. The same tree comes twice if both rows have the same position and the
/// same dbh or, where it is unknown, the same measures; or if they are of different times and not
/// known to stand apart by more than a survey errs, 1 m.
/// Otherwise two trees (or two stems of one stool) were given one number, which is no reason to
/// lose one of them.
/// \param times  (N) when each row was measured, missing where that is not known; empty: never
/// known
std::vector<RepeatedTree> repeated_trees(const Inventory& inventory, const data::TextColumn& times);

/// Trees with the number of another one, of an inventory or of its parts one after another.
struct RepeatedNumbers {
  std::size_t renamed = 0;      ///< got a new number
  std::size_t stems = 0;        ///< of these, at the place of the other tree
  std::size_t unplaced = 0;     ///< of these, without a position and a time
  std::string first_renamed{};  ///< where it is, and its new number

  std::vector<std::string> notes() const;
};

/// Excludes rows that tell of a tree once more, and gives other trees ids of their own.
/// \param tree_column  what the file calls the tree's id
/// \param times        as of repeated_trees
/// \param checked      gets the exclusions, in the order of lines
/// \param positions    for each tree its row of the file; loses those of excluded rows
/// \param numbers      gets the trees with new ids
void resolve_repeated_trees(const std::string& tree_column,
                            const data::TextColumn& times,
                            CheckedInventory& checked,
                            std::vector<std::size_t>& positions,
                            RepeatedNumbers& numbers);

}  // namespace silvafit::stand
