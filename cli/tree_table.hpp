// SPDX-License-Identifier: MIT
// Tables of trees that commands with models and builders read, with --columns and what spreadsheets
// leave in them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "command.hpp"
#include "sheet_options.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::cli {

/// Adds --columns.
CLI::Option* add_columns_option(CLI::App& command, std::vector<std::string>& columns);

/// The entries NAME=COLUMN,... of --columns, as inventories read them.
/// \throws UsageError for one that is none, or a name that comes twice
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A table and how it was read: titles, columns, units, codes, spellings, dead trees.
struct ReadTable {
  data::Table table{};
  std::vector<std::string> recognized{};
};

/// A CSV file for builders of trees, which read the columns of `columns` themselves: plot, tree and
/// species stay text, whatever they are called. Columns of ours that the file has under a usual
/// name or in another unit only, such as dbh as `BHD (mm)`, are added under our names. Dead trees
/// are left out unless they are to be included. What was recognized is said.
/// \param columns  NAME -> COLUMN of --columns; columns in other units become expressions
/// \throws as data::read_csv_table(); UsageError if two columns could be one of ours
ReadTable read_tree_table(const std::filesystem::path& file,
                          std::map<std::string, std::string>& columns,
                          const SheetArguments& sheet,
                          const CommonOptions& common);

/// What models read of a file.
struct ModelColumns {
  std::vector<std::string> entries{};    ///< of --columns
  std::vector<std::string> names{};      ///< columns that keep their spelling ("07"), as models say
  std::vector<std::string> wanted{};     ///< looked for under their usual names, too
  stand::StructuralUnitOptions units{};  ///< of indices that entries ask for: C=C
  SheetArguments sheet{};
  bool trust_units = false;      ///< do not ask whether some plots have another unit
  bool keeps_spellings = false;  ///< species are what the file has, as in any other table
};

/// A CSV file for models, with the columns that --columns names, and with wanted ones of ours that
/// the file has under a usual name or in another unit only. What was recognized, and which indices
/// were computed, is said.
/// \throws as read_tree_table() and study::add_columns(); InputError if plots have other units
ReadTable read_model_table(const std::filesystem::path& file,
                           const ModelColumns& columns,
                           const CommonOptions& common);

/// The fields that --fill-down means, by position in a header.
/// \param names   of columns of the file, or plot, tree and species
/// \param mapped  entries of --columns
/// \throws UsageError if there is no such column
std::vector<std::size_t> filled_fields(const std::vector<std::string>& header,
                                       const std::vector<std::string>& names,
                                       const std::vector<std::string>& mapped,
                                       const std::string& file);

}  // namespace silvafit::cli
