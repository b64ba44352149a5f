// SPDX-License-Identifier: MIT
// The groups of the terms of random effects.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// Cells are sets of rows that are in the same group of every term; they are the groups of the
/// model, with one or two nested terms those of the last. Clusters are sets of cells that no group
/// connects to others: the groups of the first of nested terms.
struct ModelGroups {
  bool is_crossed = false;                          ///< see RandomEffects::is_crossed
  std::vector<std::vector<std::string>> labels{};   ///< (G) of each term
  std::vector<std::vector<Index>> of_cells{};       ///< (cells) group in each term
  std::vector<Index> first_cell{};                  ///< (clusters + 1)
  std::vector<std::vector<Index>> cluster_begin{};  ///< (clusters + 1) first group, by term

  Index cell_count() const { return first_cell.back(); }
  /// The group of a term that a cell is in.
  Index group_of(std::size_t term, Index cell) const {
    return of_cells[term][static_cast<std::size_t>(cell)];
  }

  /// Crossed groups, all in one cluster.
  static ModelGroups one_cluster(std::vector<std::vector<std::string>> labels,
                                 std::vector<std::vector<Index>> of_cells);
  /// The same of some of the cells.
  /// \param cells          in ascending order
  /// \param cluster_cells  (clusters + 1) first of them in each cluster
  ModelGroups part(const std::vector<Index>& cells, std::vector<Index> cluster_cells) const;
  /// What identifies a cell: the label of the term whose groups are the cells, or those of all.
  std::string cell_label(Index cell) const;
};

/// Rows in the order of clusters and cells.
struct CellRows {
  ModelGroups groups{};
  std::vector<std::size_t> rows{};
  std::vector<Index> cell_begin{};  ///< (cells + 1)
};

/// \param complete  (rows of the table) those that may be used; rows without a group are not
CellRows cell_rows(const ModelSpecification& specification,
                   const data::Table& table,
                   const std::vector<bool>& complete);

}  // namespace silvafit::fit
