// SPDX-License-Identifier: MIT
// Reading tables of trees whose columns may have other names than ours.
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

/// The entries NAME=COLUMN,... of --columns, as inventories read them.
/// \throws UsageError for one that is none, or a name that comes twice
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A CSV file for builders of trees, which read the columns of `columns` themselves: plot, tree and
/// species stay text, whatever they are called. Columns of ours that the file has under a usual
/// spelling only, such as dbh as DBH_cm, are added under our names, which is said.
/// \throws as data::read_csv_table(); UsageError if two columns could be one of ours
data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns,
                            const CommonOptions& common);

/// What models read of a file.
struct ModelColumns {
  std::vector<std::string> entries{};    ///< of --columns
  std::vector<std::string> names{};      ///< columns that keep their spelling ("07"), as models say
  std::vector<std::string> wanted{};     ///< looked for under their usual spellings, too
  stand::StructuralUnitOptions units{};  ///< of indices that entries ask for: C=C
};

/// A CSV file for models, with the columns that --columns names, and with wanted ones of ours that
/// the file has under a usual spelling only; the latter, and computed indices, are said.
/// \throws as read_tree_table() and study::add_columns()
data::Table read_model_table(const std::filesystem::path& file,
                             const ModelColumns& columns,
                             const CommonOptions& common);

}  // namespace silvafit::cli
