// SPDX-License-Identifier: MIT
// What the 3D page shows: trees with their measurements, and models to draw them with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "silvafit/tree/preset.hpp"

namespace silvafit::study {

struct ViewOptions {
  std::string title{};
  std::string version{};  ///< of the program
  /// Where columns have other names or units, as in tree::MorphologyTableOptions; those of h, hcb
  /// and cw are of the observed sizes.
  std::map<std::string, std::string> columns{};
  std::vector<std::string> plots{};   ///< plots to show; empty means all
  std::size_t models_per_preset = 6;  ///< shapes of a species preset that its trees share
  std::vector<int> levels{0, 1, 2, 3};
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0 means as many as there are cores
};

/// The page's data with what was counted on the way.
struct View {
  std::string data{};          ///< JSON, schema silvafit-view/1: docs/view.md
  std::size_t trees = 0;       ///< with measurements
  std::size_t unmeasured = 0;  ///< trees of a scene in which none has measurements
  std::size_t models = 0;
  std::vector<std::string> variants{};  ///< sizes to be shown: "observed", "ols", ...
  std::vector<tree::LeftOut> left_out{};
  std::vector<std::string> notes{};  ///< what the reader must know, for people
};

/// A stand from a table of measured or predicted trees, such as an inventory or a study's
/// predictions.csv.
///
/// The stand has a variant for each set of sizes that the table holds: h, hcb and cw as observed,
/// by least squares (h_ols, ...), and by the mixed models for the population and the plot
/// (h_population, h_conditional, ...). Trees of all variants share the models of their preset; the
/// page draws each with its own height, crown base, height of the widest crown, four radii and DBH.
///
/// Columns: as tree::read_morphologies reads them, with x and y, and where there are any W, M, U, C
/// and core. The same arguments give the same bytes.
/// \throws InputError if a column that is needed is not there or no tree can be shown; UsageError
///         for options that cannot be; GeometryError as tree::grow_tree()
View view_of_trees(const data::Table& table,
                   const tree::PresetCatalogue& catalogue,
                   const ViewOptions& options);

/// A scene of a GLB file as it is.
///
/// Measurements are those that `silvafit grow` wrote beside each tree. Scenes without them (shared
/// models, files of other programs) are shown all the same; where the table of the trees is given,
/// trees get its measurements: by the name "plot-tree" of their node, or by the number of their row
/// where instances have one.
/// \param glb    bytes of a GLB file
/// \param table  null without
/// \throws InputError if it is no GLB file, or no tree of the table is in it
View view_of_scene(std::string_view glb,
                   const data::Table* table,
                   const tree::PresetCatalogue& catalogue,
                   const ViewOptions& options);

}  // namespace silvafit::study
