// SPDX-License-Identifier: MIT
// Several rows with the same plot and tree, and plots with the same label in several stands.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/repeated_trees.hpp"

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
  std::size_t again = 0;  ///< skipped rows that measure a tree again within a visit
  VisitCounts visits{};

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

/// Finds labels of plots that occur in several stands.
class SharedPlotLabels {
 public:
  void add(std::string_view plot, std::string_view stand);
  /// The plots so far do not occur again; they are counted and removed from memory.
  void finish_plots();
  /// A note on these plots; empty if there are none.
  /// \param column  that the stands are in
  std::string note(const std::string& column) const;
  struct Example {
    std::string label{};
    std::string first{};  ///< first stand with the label
    std::string other{};  ///< the next one
  };
  std::optional<Example> first() const;
  /// The note if the labels are places, and their "stands" the plots of a visit each.
  std::string note_on_visits() const;

 private:
  struct Shared {
    std::string first{};  ///< first stand with the label
    std::string other{};  ///< the next one
  };

  std::unordered_map<std::string, std::string> stand_of_plot_{};  ///< first stand of each label
  std::map<std::string, Shared> shared_{};  ///< labels of several stands: after finish_plots() one
  std::size_t forgotten_ = 0;               ///< number of labels that were removed
  std::string last_plot_{};
  std::string last_stand_{};
};

}  // namespace silvafit::stand
