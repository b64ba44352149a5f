// SPDX-License-Identifier: MIT
// Reading the table of trees that `grow` and `view` take.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::cli {

/// The entries NAME=EXPRESSION of --columns.
/// \throws UsageError for one that is none
std::map<std::string, std::string> column_map(const std::vector<std::string>& entries);

/// A CSV file whose columns for plot, tree and species stay text, whatever they are called.
/// \throws as data::read_csv_table()
data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns);

}  // namespace silvafit::cli
