// SPDX-License-Identifier: MIT
// Several rows with the same plot and tree, and several visits of a plot.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// A row of an earlier visit of its plot, or with the plot and tree of an earlier row.
struct RepeatedTree {
  std::size_t row = 0;
  std::string later_visit{};        ///< the time of the plot's last visit, if the row is of another
  std::size_t first_row = 0;        ///< if it is the same tree, the first row of that tree
  bool is_same_tree = false;        ///< a copy, or a repeated measurement
  bool is_later = false;            ///< a repeated measurement: the time is another one
  bool is_same_place = false;       ///< another tree, or another stem of the same stool
  bool is_of_unknown_time = false;  ///< another tree, or the same one: time and place are unknown
  std::string new_id{};             ///< of another tree: an id of its own, such as `64#2`
};

/// Trees of rows that are not in an inventory: dead and cut ones, and those of invalid rows.
struct TimedTrees {
  data::TextColumn plot{};
  data::TextColumn tree{};
  data::TextColumn time{};
};

/// Counts of the visits of plots, of an inventory or of its parts one after another.
struct VisitCounts {
  std::size_t plots = 0;      ///< of which only the last visit is used
  std::size_t rows = 0;       ///< of earlier visits
  std::size_t unseen = 0;     ///< trees of the visit before the last one without a row of it
  std::string first{};        ///< such a plot and its last visit
  std::size_t mixed = 0;      ///< plots with several times at which no tree comes again
  std::string first_mixed{};  ///< such a plot and its times
  bool is_long = false;       ///< these are more years apart than a campaign takes
  std::size_t older = 0;      ///< plots measured only before the last visits of the others
  std::string first_older{};

  void add(const VisitCounts& other);
  std::vector<std::string> notes() const;
};

struct RepeatedTrees {
  std::vector<RepeatedTree> rows{};  ///< ascending
  VisitCounts visits{};
  /// All rows of each number that several trees have at an unknown time.
  std::vector<std::vector<std::size_t>> shared_numbers{};
};

/// Classifies the rows of plots that were visited several times, and those with the plot and tree
/// of an earlier row of the same visit.
///
/// Only the last visit of a plot describes its stand. Times are different visits if they are more
/// than a quarter of a year apart (a campaign is shorter) and a tree of the earlier one comes
/// again: otherwise the rows are of one visit that took several years, or the times are not those
/// of measurements.
///
/// A row is of the same tree if both rows have the same position, species, stem and dbh or, without
/// a position, are equal in all columns; or if they have different times and their distance is at
/// most the error of a second survey, 1 m. Otherwise two trees (or two stems of one stool) have the
/// same number. Equal rows are of different trees, too, if their number is that of no tree: 0, a
/// word, or that of three or more trees some of whose rows stand more often in the table than
/// others.
/// \param inventory  with the contents of its rows
/// \param times    (N) when each row was measured, missing where unknown; empty: always unknown
/// \param skipped  rows that are not in the inventory, whose times are visits, too
/// \param thickest_first  of trees with one number the thickest keeps it, else the first row
/// \throws InputError if trees come again at times that have no order
RepeatedTrees repeated_trees(const Inventory& inventory,
                             const data::TextColumn& times,
                             const TimedTrees& skipped = {},
                             bool thickest_first = false);

}  // namespace silvafit::stand
