// SPDX-License-Identifier: MIT
// Several rows with the same plot and tree.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/repeated_trees.hpp"
#include "trees/distinguishing_columns.hpp"

namespace silvafit::stand {

/// Counts of trees with the number of another tree, of an inventory or of its parts one after
/// another.
struct RepeatedNumbers {
  std::size_t renamed = 0;        ///< got a new number
  std::size_t stems = 0;          ///< of these, at the position of the other tree
  std::size_t unplaced = 0;       ///< of these, without a position and a time
  std::string first_renamed{};    ///< its line and its new number
  std::size_t further_stems = 0;  ///< rows of trees with several stems, by the column of stems
  std::string first_further_stem{};
  std::size_t equal = 0;  ///< rows without numbers that equal an earlier one, with its position
  std::string first_equal{};
  std::size_t again = 0;  ///< skipped rows that measure a tree again within a visit
  VisitCounts visits{};
  /// Of the last part: the rows of each number that several trees have at an unknown time, and
  /// whether these are most numbers and their rows as alike as measurements of one tree; then of
  /// each number and species.
  std::vector<LabelParts> shared{};
  bool are_alike = false;
  std::string advice{};  ///< "; ..." how rows of one number are told apart; empty without such

  std::vector<std::string> notes() const;
};

/// Excludes repeated rows of a tree, and gives new ids to other trees with the same number.
/// \param tree_column  name of the column of tree ids in the file
/// \param times, skipped, thickest_first  as of repeated_trees
/// \param checked      gets the exclusions, in the order of lines
/// \param positions    for each tree its row of the file; loses those of excluded rows
/// \param numbers      gets the trees with new ids
void resolve_repeated_trees(const std::string& tree_column,
                            const data::TextColumn& times,
                            const TimedTrees& skipped,
                            bool thickest_first,
                            CheckedInventory& checked,
                            std::vector<std::size_t>& positions,
                            RepeatedNumbers& numbers);

}  // namespace silvafit::stand
