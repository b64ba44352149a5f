// SPDX-License-Identifier: MIT
// Structural indices and stand figures as columns of a table, by name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::study {

/// Whether a quantity of this name can be computed from a stand. Per tree: W, M, U, C, CO, T,
/// Hegyi, BAL, CCF, core (0 or 1) and weight. Of its plot: stems_per_ha, basal_area_per_ha [m2],
/// quadratic_mean_dbh [cm] and dominant_height [m].
bool is_structure_name(std::string_view name);
/// Whether it is a value of a plot per hectare, or a mean of its trees, which needs its area.
bool is_plot_value_name(std::string_view name);

/// Whether it is computed of a tree's neighbors, not of all trees.
bool is_of_neighbors(std::string_view name);

/// The structure names that texts mention (formulas, sub-models, conditions) and that are no column
/// of the table, in the order of first mention. Text in double quotes and names of functions are
/// ignored. Empty if the table has no columns x, y and dbh to compute them from.
std::vector<std::string> structure_names_in(const std::vector<std::string>& texts,
                                            const data::Table& table);

/// Computes structure columns that the table lacks and adds them under their names.
///
/// The table's columns plot, tree, species, x, y, dbh, h, cw and the crown radii are read as those
/// of an inventory; without plot, all rows are one. Rows without position or dbh have no indices,
/// and are no neighbors.
/// \param names    structure names; columns that the table has remain unchanged
/// \param options  `further` is filled in here
/// \return         notes on assumptions and on values that could not be computed
/// \throws UsageError if a name is no structure name; InputError if the table has no columns x, y
///         and dbh; else as stand::structural_units
std::vector<std::string> add_structure_columns(const std::vector<std::string>& names,
                                               data::Table& table,
                                               stand::StructuralUnitOptions options = {});

/// Adds the figures of plots among the names (stems_per_ha, ...) from the plots' own areas and
/// trees, as far as the table lacks them.
void add_plot_columns(const std::vector<std::string>& names,
                      const stand::Inventory& inventory,
                      const std::vector<stand::SampledArea>& areas,
                      data::Table& table);

}  // namespace silvafit::study
