// SPDX-License-Identifier: MIT
// Reading the table of trees that `grow` and `view` take.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::cli {

/// Adds --columns.
CLI::Option* add_columns_option(CLI::App& command, std::vector<std::string>& columns);

/// The entries NAME=COLUMN,... of --columns, as inventories read them.
/// \throws UsageError for one that is none, or a name that comes twice
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A CSV file whose columns for plot, tree and species stay text, whatever they are called. Columns
/// of ours that the file has under a usual spelling only, such as dbh as DBH_cm, are added under
/// our names, which is said; those that `columns` maps are not.
/// \throws as data::read_csv_table(); UsageError if two columns could be one of ours
data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns,
                            const CommonOptions& common);

}  // namespace silvafit::cli
