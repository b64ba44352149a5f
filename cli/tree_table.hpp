// SPDX-License-Identifier: MIT
// Reading tables of trees with other column names than ours.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::cli {

/// Adds --columns.
CLI::Option* add_columns_option(CLI::App& command, std::vector<std::string>& columns);

/// The entries NAME=COLUMN,... of --columns, as for inventories.
/// \throws UsageError for an invalid entry, or a repeated name
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A CSV file for builders of trees, which read the columns of `columns` themselves: plot, tree and
/// species stay text, for any column name. Standard columns that the file has only with another
/// common spelling, such as dbh as DBH_cm, are added with our names, with a note.
/// \throws as data::read_csv_table(); UsageError if two columns match one of ours
data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns,
                            const CommonOptions& common);

/// The columns that models read.
struct ModelColumns {
  std::vector<std::string> entries{};    ///< of --columns
  std::vector<std::string> names{};      ///< columns that keep their spelling ("07")
  std::vector<std::string> wanted{};     ///< also searched with their common spellings
  stand::StructuralUnitOptions units{};  ///< of indices that entries request: C=C
};

/// A CSV file for models, with the columns of --columns, and with requested standard columns that
/// the file has only with another common spelling; notes list the latter and computed indices.
/// \throws as read_tree_table() and study::add_columns()
data::Table read_model_table(const std::filesystem::path& file,
                             const ModelColumns& columns,
                             const CommonOptions& common);

}  // namespace silvafit::cli
