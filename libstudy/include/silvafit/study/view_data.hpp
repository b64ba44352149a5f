// SPDX-License-Identifier: MIT
// Data of the 3D page: trees with their measurements, and models for drawing them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/raster.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/tree/builder.hpp"
#include "silvafit/tree/morphology_table.hpp"

namespace silvafit::study {

struct ViewOptions {
  std::string title{};
  std::string version{};  ///< of the program
  /// Columns with other names or units, as in tree::MorphologyTableOptions; those of h, hcb and cw
  /// are of the observed sizes.
  std::map<std::string, std::string> columns{};
  std::vector<std::string> plots{};  ///< plots to show; empty: all
  /// Column whose trees with a number other than 0 are removed by a thinning; empty: none.
  std::string mark{};
  std::size_t models_per_preset = 6;  ///< number of models of a species preset
  std::vector<int> levels{0, 1, 2, 3};
  bool reads_codes = true;                        ///< numbers of species are codes of FIA
  std::shared_ptr<const data::Raster> terrain{};  ///< of the ground; null: through the stem bases
  bool textures = true;  ///< pictures of bark and shoots, else leaves as polygons in plain colors
  tree::Season season = tree::Season::kSummer;
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one for each core
};

/// The page's data and its counts.
struct View {
  std::string data{};          ///< JSON, schema silvafit-view/1: docs/view.md
  std::size_t trees = 0;       ///< with measurements
  std::size_t unmeasured = 0;  ///< trees of a scene without any measurements
  std::size_t models = 0;
  std::vector<std::string> variants{};  ///< sizes that can be shown: "observed", "ols", ...
  std::vector<tree::LeftOut> left_out{};
  std::vector<std::string> notes{};  ///< notes for the reader
};

/// A stand from a table of measured or predicted trees, such as an inventory or a study's
/// predictions.csv.
///
/// The stand has a variant for each set of sizes in the table: h, hcb and cw as observed,
/// by least squares (h_ols, ...), and by the mixed models for the population and the plot
/// (h_population, h_conditional, ...). Trees of all variants share the models of their preset; the
/// page draws each with its own height, crown base, height of the widest crown, four radii and DBH.
///
/// Columns: as read by tree::read_morphologies, with x and y, and if present W, M, U, C
/// and core. The same arguments give the same bytes.
/// \throws InputError if a required column is missing or no tree can be shown; UsageError
///         for invalid options; GeometryError as tree::grow_tree()
View view_of_trees(const data::Table& table,
                   const tree::BuilderCatalogue& catalogue,
                   const ViewOptions& options);

/// A scene of a GLB file, unchanged.
///
/// Measurements are those that `silvafit grow` wrote for each tree. Scenes without them (shared
/// models, files of other programs) can be shown, too; if the table of the trees is given,
/// trees get its measurements: by the name "plot-tree" of their node, or by the index of their row
/// for instances.
/// \param glb    bytes of a GLB file
/// \param table  null without
/// \throws InputError if it is not a GLB file, or no tree of the table is in it
View view_of_scene(std::string_view glb,
                   const data::Table* table,
                   const tree::BuilderCatalogue& catalogue,
                   const ViewOptions& options);

}  // namespace silvafit::study
