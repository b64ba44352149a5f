// SPDX-License-Identifier: MIT
// Inventories of whole regions in tiles: each is processed independently, on any machine. The
// merged results are those of the whole inventory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/window.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/grow.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/predict_table.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct TileSettings {
  double size_m = 500.0;  ///< side of a tile; its corners are multiples of it
  double halo_m = 30.0;   ///< width of the strip around a tile whose trees are its neighbors
  ReadingSettings reading{};
};

/// A square of the grid. A tree on the line between two squares is in the eastern or northern one.
struct Tile {
  std::int64_t column = 0;    ///< x from column * size_m to (column + 1) * size_m
  std::int64_t row = 0;       ///< likewise y
  std::size_t trees = 0;      ///< rows of its own
  std::size_t neighbors = 0;  ///< rows in its halo
  std::string fingerprint{};  ///< of the rows in its file

  /// Such as e12s3, in the names of files.
  std::string name() const;
};

/// The tiles of an inventory, and properties of the whole inventory.
struct TilePlan {
  std::string inventory{};
  TileSettings settings{};
  data::TableHead head{};   ///< of the inventory
  char separator = ',';     ///< of the files of tiles
  std::string where{};      ///< the condition for rows; empty: all are in tiles
  std::size_t rows = 0;     ///< of the inventory that satisfy it
  std::size_t trees = 0;    ///< usable rows
  bool has_plots = false;   ///< more than one plot
  bool ids_repeat = false;  ///< trees of different plots have the same id
  stand::Point low{};       ///< corners of the rectangle around all trees
  stand::Point high{};
  std::vector<stand::Point> hull{};  ///< convex hull of all trees; none if they are on one line
  std::vector<Tile> tiles{};
  std::string version{};      ///< of the silvafit that made the plan
  std::string fingerprint{};  ///< of all of the above
};

/// Cuts a CSV file into a file for each tile with trees, `FOLDER/tiles/NAME.csv`: line in the
/// inventory, whether the row is the tile's own, then the columns of the inventory. Rows that
/// cannot be used as trees are in the tile of the previous tree. Then writes `FOLDER/plan.json`.
/// The rows are sorted on disk; memory does not grow with the file.
/// \throws UsageError if a setting
/// is out of range; InputError if trees have no numbers, a number
///   occurs twice in a plot, or spellings of a species would be unified
TilePlan plan_tiles(const std::filesystem::path& inventory,
                    const TileSettings& settings,
                    const std::filesystem::path& folder,
                    const Callbacks& callbacks = {});

/// Reads the plan of a folder.
/// \throws InputError if there is none, or it is damaged
TilePlan read_tile_plan(const std::filesystem::path& folder);

/// As JSON, schema silvafit-tiles/1 (docs/json.md).
nlohmann::ordered_json json_of(const TilePlan& plan);

/// The result of one tile.
struct TileResult {
  std::string file{};
  bool was_there = false;  ///< kept from an earlier run with the same settings
  std::size_t trees = 0;   ///< rows of the result
  /// Trees whose neighbors may be outside of the halo. Their values are empty.
  std::size_t marked = 0;
  double halo_m = 0.0;  ///< no tree of the tile needs a wider halo; infinite where that is unknown
};

/// Computes the structural units of the trees of a tile, `FOLDER/indices/NAME.csv`. The file is
/// written whole or not at all; a whole one of the same inventory and settings is left as it is.
/// \param tile      position in TilePlan::tiles
/// \param settings  without BAL, CCF and the edge corrections torus and hanisch, which need all
///                  trees of the stand
/// \throws UsageError for these, and for --per plot if the inventory has several plots
TileResult tile_indices(const std::filesystem::path& folder,
                        const TilePlan& plan,
                        std::size_t tile,
                        const UnitSettings& settings,
                        unsigned threads = 0);

/// Predicts for the trees of a tile, `FOLDER/predict/NAME.csv`.
/// \param settings  without calibration and computed indices, which need the trees of whole plots
/// \param key       identifies the library
/// \throws UsageError for these; else as predict_table
TileResult tile_predictions(const std::filesystem::path& folder,
                            const TilePlan& plan,
                            std::size_t tile,
                            const ModelLibrary& library,
                            const Catalogue& catalogue,
                            const PredictionSettings& settings,
                            int digits,
                            const std::string& key);

/// Grows the trees of a tile, but not those of its halo, as a scene `FOLDER/grow/NAME.glb`. A tree
/// has the shape that it has in a scene of the whole inventory. `FOLDER/grow/NAME.csv` names the
/// scene; a tile in which no tree can be grown has none.
/// \param settings  of the scene: without files, overlaps and times, which need other trees
/// \param key       identifies the settings
/// \throws UsageError for these; else as grow
TileResult tile_scene(const std::filesystem::path& folder,
                      const TilePlan& plan,
                      std::size_t tile,
                      const tree::BuilderCatalogue& catalogue,
                      const GrowSettings& settings,
                      const std::string& key,
                      const Callbacks& callbacks = {});

/// Reasons why a result is incomplete.
struct TileGaps {
  std::vector<std::size_t> missing{};  ///< tiles without a result
  /// Tiles whose results, or scenes, differ from their fingerprint, or whose scenes are missing.
  std::vector<std::size_t> damaged{};
  /// Tiles whose results have other settings, or are of another plan, than the first one's.
  std::vector<std::size_t> different{};

  bool are_none() const { return missing.empty() && damaged.empty() && different.empty(); }
};

struct MergedTiles {
  TileGaps gaps{};  ///< if there are any, nothing was written
  std::size_t trees = 0;
  std::size_t marked = 0;
  double halo_m = 0.0;  ///< enough for all marked trees
};

/// Joins the results of a command, in the order of the inventory: the bytes are those of the
/// command for the whole inventory. If trees are marked, a last column `halo` is `too small` for
/// them. The result of grow is a table of the scenes, which stay where they are.
/// \param command  indices, predict or grow
MergedTiles merge_tiles(const std::filesystem::path& folder,
                        const TilePlan& plan,
                        const std::string& command,
                        std::ostream& stream);

}  // namespace silvafit::study
