// SPDX-License-Identifier: MIT
// Trees of which only the diameter was measured, for pictures.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// Numbers of trees whose height, crown base and crown width were assumed by the formulas of dbh,
/// and whose crown width was by some measured radii.
struct AssumedSizes {
  std::array<std::size_t, 3> by_dbh{};
  std::size_t by_radii = 0;
};

/// Sets heights, crown bases and crown widths where they are missing, by a fixed formula of dbh.
/// The column tree::kAssumedColumn names those of each tree.
/// \param columns  sources of standard columns; those that are completed are removed
/// \param counts   of earlier parts; those of this table are added
void assume_sizes(data::Table& table,
                  std::map<std::string, std::string>& columns,
                  AssumedSizes& counts);

/// A note on columns of predictions that are not used; empty if there are none.
std::string note_on_predictions(const data::Table& table);

/// A note with the number of trees and the formula of each; empty if nothing was missing.
std::string note_on(const AssumedSizes& counts);

/// The labels of inventories without these columns: plot 1, and trees numbered from 1.
void assume_labels(data::Table& table, const std::map<std::string, std::string>& columns);

}  // namespace silvafit::study
