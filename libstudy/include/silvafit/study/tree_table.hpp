// SPDX-License-Identifier: MIT
// Tables of trees for models and builders: columns under other names or in other units, and
// corrections of values from spreadsheets.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/odd_values.hpp"
#include "silvafit/stand/repeated_trees.hpp"
#include "silvafit/stand/species_spellings.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/tree_status.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// The entries NAME=COLUMN of ReadingSettings::columns, by name.
/// \throws UsageError for one that is none, or a name that comes twice
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A table and notes on how it was read: titles, columns, units, codes, spellings, dead trees.
struct ReadTable {
  data::Table table{};
  std::vector<std::string> recognized{};
  /// Standard columns that are other columns of the file, unchanged: h is Height.
  std::map<std::string, std::string> columns{};
  bool has_fia_species = true;  ///< stand::may_have_fia_species()
};

/// Such a table as observations: a row with the plot, tree and all other values of an earlier one
/// is a copy of it and no observation.
struct ObservedTable : ReadTable {
  std::vector<std::size_t> distinct{};  ///< if there are copies, all other rows, ascending
  /// For each row its place in `distinct`; a copy has that of the row it copies. Empty if there are
  /// no copies.
  std::vector<std::size_t> place{};
  /// Of ModelColumns::finds_dead: 1 for rows without a living tree; empty if all have one.
  std::vector<char> is_dead{};

  /// The rows that are no copies.
  data::Table observations() const { return place.empty() ? table : table.select(distinct); }
};

/// Rows with the plot and tree of an earlier row.
struct RepeatCounts {
  std::size_t copies = 0;    ///< with the same values
  std::string first_copy{};  ///< where it is, for the note
  std::size_t others = 0;    ///< with other values
  std::size_t later = 0;     ///< with another time

  std::vector<std::string> notes() const;
};

/// Rows of trees that have a row already, where each tree has one.
struct RepeatedTreeCounts {
  std::size_t same = 0;      ///< the same tree; they are skipped
  std::string first_same{};  ///< where it is, for the note
  std::size_t others = 0;    ///< another tree, which gets a new number
  std::string first_other{};
  stand::VisitCounts visits{};

  std::vector<std::string> notes() const;
};

/// The state of reading a file in parts (data::TableParts): the notes on the last part
/// are those on the whole file. Units are compared in the first part only, and labels of plots that
/// differ little are not searched.
struct ReadingState {
  data::MissingCodes codes{};
  stand::SpeciesSpellings spellings{};
  std::optional<stand::StatusColumn> status{};
  RepeatCounts repeated{};
  RepeatedTreeCounts repeated_trees{};
  std::size_t off_terrain = 0;  ///< trees that are not on ReadingSettings::terrain
  std::size_t sums = 0;         ///< rows of sums or means
  std::string first_sum{};
  stand::OddValues odd_values{};
  std::map<std::string, std::size_t> computed{};  ///< notes on computed indices, with parts
  bool is_begun = false;
};

/// A table for builders of trees, which read the columns of `columns` themselves: plot, tree and
/// species remain text, whatever their names. Our columns that the source has under a usual
/// name or in another unit only, such as dbh as `BHD (mm)`, are added under our names. Dead trees
/// are excluded unless they are to be included. Without `by`, each tree has one row at one time
/// (docs/inventory.md). On a terrain, the column z is that of the terrain.
/// \param by       the column of the times, of which each tree may have several; empty: one time
/// \param columns  gets NAME -> COLUMN of the settings; columns in other units become expressions
/// \param state    of the parts before; null: this is the whole table
/// \param dead_wood  dead trees stay, and the table gets the column `remains`
/// (morphology_table.hpp) \throws as data::read_csv_table(); UsageError if two columns could be one
/// of ours
ReadTable read_tree_table(const data::TableSource& source,
                          const ReadingSettings& settings,
                          const std::string& by,
                          std::map<std::string, std::string>& columns,
                          const NoteCallback& note = {},
                          ReadingState* state = nullptr,
                          bool dead_wood = false);

/// The requirements of models for a table.
struct ModelColumns {
  std::vector<std::string> names{};      ///< columns that keep their spelling ("07"), as models say
  std::string random{};                  ///< random effects, whose groups may be numbered in others
  std::vector<std::string> wanted{};     ///< looked for under their usual names, too
  stand::StructuralUnitOptions units{};  ///< of indices that the settings' columns ask for: C=C
  bool keeps_spellings = false;          ///< species are what the source has
  bool finds_dead = false;               ///< find ObservedTable::is_dead, unless they are included
  bool keeps_sums = false;               ///< rows of sums and means stay
  std::vector<std::string> species{};    ///< whose spelling is given
  ReadingState* state = nullptr;         ///< of the parts before; null: this is the whole table
};

/// A table for models, with the columns that the settings name, and those of our columns that
/// the source has under a usual name or in another unit only, if they are needed.
/// \throws as read_tree_table() and study::add_columns(); InputError if plots have other units
ObservedTable read_model_table(const data::TableSource& source,
                               const ReadingSettings& settings,
                               const ModelColumns& columns,
                               const NoteCallback& note = {});

/// Checks the sizes of a table that is no file and has our columns.
/// \throws InputError if a column or a plot has another unit
void check_units(const data::Table& table);

}  // namespace silvafit::study
