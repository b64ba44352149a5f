// SPDX-License-Identifier: MIT
// Morphologies from a table of measured or predicted trees.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// The columns of h, hcb and cw.
enum class Use { kObserved, kOls, kPopulation, kConditional, kPredicted };
constexpr std::array<std::string_view, 5> words_of(Use /*use*/) {
  return {"observed", "ols", "population", "conditional", "pred"};
}

/// A column with the sizes of each tree that were not measured ("h, hcb"), if there are any. No
/// header of a file has this name.
inline constexpr char kAssumedColumn[] =
    "\x1f"
    "assumed";

struct MorphologyTableOptions {
  /// kObserved reads h, hcb, cw and, if present, cr_e, cr_w, cr_s, cr_n and hc. The others
  /// read h_population, hcb_population, cw_population and so on, and no radii or hc, which would
  /// not fit to predicted crowns.
  Use use = Use::kObserved;
  /// Columns with other names or units: standard name -> a column of the table, by its exact name,
  /// or an expression of its columns (data::column_reference). plot, tree and species need a
  /// column.
  std::map<std::string, std::string> columns{};
  std::vector<std::string> plots{};  ///< plots to read; empty means all
  bool needs_position = false;       ///< x and y are required
  /// For trees that are drawn as they are: dbh, hcb, cw and everything else of the shape except h
  /// are not read.
  bool only_height = false;
  /// Reads `remains` (snag, stump, log or living; empty: living) and, if present, `decay`.
  bool dead_wood = false;
};

/// A row that cannot be used.
struct LeftOut {
  Place place{};  ///< its column with the name in the table, such as h_ols or BHD/10
  std::string reason{};
};

struct MorphologyTable {
  std::vector<Morphology> morphologies{};  ///< in the order of the rows
  std::vector<LeftOut> left_out{};
};

/// Reads the columns plot, tree, species, x, y, z (m), dbh (cm), h, hcb, cw (m), and, if present,
/// cr_e, cr_w, cr_s, cr_n, hc (m), age (years), and for bamboo bend_deg, bend_azimuth_deg,
/// internodes (number) and branch_angle_deg. A row with missing or impossible values,
/// or with a label that the plot already has, is skipped with the reason.
/// \throws InputError if a required column is missing, or a chosen plot has no row;
/// FormulaError, UsageError for anything that is neither a column nor an expression of columns
MorphologyTable read_morphologies(const data::Table& table, const MorphologyTableOptions& options);

}  // namespace silvafit::tree
