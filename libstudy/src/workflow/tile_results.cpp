// SPDX-License-Identifier: MIT
// Results of tiles, and the merged result of the whole inventory.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/data/ordered_rows.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/rows_with_columns.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/study_files.hpp"
#include "study/settings_json.hpp"
#include "workflow/tile_files.hpp"

namespace silvafit::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// Differences of distances that are due to rounding and are ignored in ties of neighbors.
constexpr double kRoundingMeters = 1e-6;

void require_tile(const TilePlan& plan, std::size_t tile) {
  if (tile < plan.tiles.size()) return;
  throw UsageError(fmt::format("there are {} tiles", plan.tiles.size()), {.column = "`tile`"});
}

std::optional<TileResult> earlier_result(const fs::path& file, const std::string& key) {
  const auto head = read_result_head(file);
  if (!head || head->key != key || !is_whole_result(file, *head)) return std::nullopt;
  return TileResult{.file = file.string(),
                    .was_there = true,
                    .trees = head->trees,
                    .marked = head->marked,
                    .halo_m = head->halo_m};
}

/// The distance from a tree within which all trees are known: to the nearest side of the tile with
/// its halo. Sides beyond all trees of the inventory are ignored.
class KnownRoom {
 public:
  KnownRoom(const TilePlan& plan, const Tile& tile) {
    const double size_m = plan.settings.size_m;
    const double halo_m = plan.settings.halo_m;
    low_ = {size_m * static_cast<double>(tile.column) - halo_m,
            size_m * static_cast<double>(tile.row) - halo_m};
    high_ = {low_.x + size_m + 2.0 * halo_m, low_.y + size_m + 2.0 * halo_m};
    constexpr double kFar = std::numeric_limits<double>::infinity();
    if (low_.x < plan.low.x) low_.x = -kFar;
    if (low_.y < plan.low.y) low_.y = -kFar;
    if (high_.x > plan.high.x) high_.x = kFar;
    if (high_.y > plan.high.y) high_.y = kFar;
  }

  double around(stand::Point at) const {
    return std::min({at.x - low_.x, high_.x - at.x, at.y - low_.y, high_.y - at.y});
  }

 private:
  stand::Point low_{};
  stand::Point high_{};
};

stand::StructuralUnitOptions options_of(const TilePlan& plan,
                                        const UnitSettings& settings,
                                        unsigned threads) {
  stand::StructuralUnitOptions options = unit_options(settings, threads);
  if (options.scope == stand::SearchScope::kPlot && plan.has_plots) {
    throw UsageError(
        "the inventory has several plots, which tiles would cut: use `per=stand`, or "
        "`silvafit indices` with `stream` and no tiles",
        {.column = "`per`"});
  }
  if (options.edge == stand::EdgeCorrection::kTorus) {
    throw UsageError("a torus joins opposite sides of the stand; it cannot be cut into tiles",
                     {.column = "`edge`"});
  }
  if (options.edge == stand::EdgeCorrection::kHanisch) {
    throw UsageError(
        "the weights of Hanisch are interpolated among all trees of the stand; use `edge=buffer`",
        {.column = "`edge`"});
  }
  for (const stand::FurtherIndex index : options.further) {
    if (index != stand::FurtherIndex::kBasalAreaLarger &&
        index != stand::FurtherIndex::kCrownCompetition) {
      continue;
    }
    throw UsageError(
        fmt::format("{} is a sum over all trees of the stand; it cannot be computed in "
                    "tiles",
                    word_of(index)),
        {.column = "`further`"});
  }
  // The inventory is a part; the default window is that of all trees.
  options.is_part = true;
  if (options.windows.empty() && options.edge != stand::EdgeCorrection::kNone) {
    const auto hull = stand::Window::convex_hull(plan.hull);
    if (!hull) {
      throw UsageError("all trees are on one line and have no window; use `edge=none`",
                       {.column = "`edge`"});
    }
    options.windows.push_back({std::nullopt, *hull});
  }
  return options;
}

/// The distance up to which a tree's values depend on others; infinite if it has too few neighbors.
double needed_m(const stand::StructuralUnits& units,
                const stand::StructuralUnitOptions& options,
                std::size_t tree) {
  const double farthest_m = units.distance_m[(tree + 1) * units.neighbors - 1];
  if (std::isnan(farthest_m)) return std::numeric_limits<double>::infinity();
  const bool has_radius = std::ranges::any_of(options.further, [](stand::FurtherIndex index) {
    return index == stand::FurtherIndex::kHegyi;
  });
  return has_radius ? std::max(farthest_m, options.competition_radius_m) : farthest_m;
}

/// A row of units with labels only.
std::string without_values(std::string_view header, const stand::Inventory& trees, std::size_t i) {
  constexpr std::ptrdiff_t kLabels = 3;
  std::string row = data::csv_field(trees.plot[i]);
  row += ',' + data::csv_field(trees.tree[i]);
  row += ',' + data::csv_field(trees.species[i]);
  row.append(static_cast<std::size_t>(std::ranges::count(header, ',') + 1 - kLabels), ',');
  return row + '\n';
}

ordered_json json_of(const std::vector<stand::Point>& ring) {
  ordered_json points = ordered_json::array();
  for (const stand::Point& point : ring) points.push_back({point.x, point.y});
  return points;
}

ordered_json json_of(const std::vector<stand::NamedWindow>& windows) {
  ordered_json list = ordered_json::array();
  for (const stand::NamedWindow& window : windows) {
    list.push_back(window.plot.value_or(""));
    for (const stand::Polygon& polygon : window.window.outline()) {
      list.push_back(json_of(polygon.outer));
      for (const auto& hole : polygon.holes) list.push_back({{"hole", json_of(hole)}});
    }
  }
  return list;
}

/// All that the results of a command depend on, besides the plan.
std::string key_of(const TilePlan& plan, const std::string& command, const ordered_json& settings) {
  return fingerprint(plan.fingerprint + " " SILVAFIT_VERSION " " + command + settings.dump());
}

void require_rows_alone(const PredictionSettings& settings, const TilePlan& plan) {
  if (settings.level == fit::Level::kCalibrated) {
    throw UsageError(
        "calibration needs all trees of a plot, which tiles would cut; use "
        "`silvafit predict` with `stream`",
        {.column = "`level`"});
  }
  data::Table columns(0);
  for (const std::string& name : plan.head.header) {
    if (!name.empty()) columns.set(name, std::vector<double>());
  }
  for (const char* const name : {"x", "y", "dbh"}) columns.set(name, std::vector<double>());
  const std::vector<std::string> computed =
      structure_names_in(plan.settings.reading.columns, columns);
  if (computed.empty()) return;
  throw UsageError(
      fmt::format("{} would be computed in each tile alone; compute the indices first, "
                  "merge them, and predict from the result",
                  fmt::join(computed, ", ")),
      {.column = "`columns`"});
}

}  // namespace

TileResult tile_indices(const fs::path& folder,
                        const TilePlan& plan,
                        std::size_t tile,
                        const UnitSettings& settings,
                        unsigned threads) {
  require_tile(plan, tile);
  const stand::StructuralUnitOptions options = options_of(plan, settings, threads);
  const fs::path file = result_file(folder, "indices", plan.tiles[tile]);
  const std::string key =
      key_of(plan, "indices", {settings_json(settings), json_of(options.windows)});
  if (auto earlier = earlier_result(file, key)) return std::move(*earlier);
  const TileRows rows = read_tile(folder, plan, tile, false);
  const stand::CheckedInventory checked = stand::read_inventory(
      rows.table,
      inventory_options(plan.settings.reading, {.needs_coordinates = true, .is_part = true}));
  const stand::Inventory& trees = checked.inventory;
  const stand::StructuralUnits units = stand::structural_units(trees, options);
  const KnownRoom room(plan, plan.tiles[tile]);
  ResultRows result;
  const std::string header = stand::header_of_units(units);
  result.set_header(header);
  stand::write_structural_units(
      trees,
      units,
      [&](std::size_t i, std::string_view text) {
        const std::size_t line = trees.lines[i];
        if (!rows.is_own(line)) return;
        const double needed = needed_m(units, options, i);
        if (needed + kRoundingMeters <= room.around({trees.x[i], trees.y[i]})) {
          return result.add(line, text);
        }
        result.need_halo(needed);
        result.add_marked(line, without_values(header, trees, i));
      },
      plan.ids_repeat);
  return result.write(file, key);
}

TileResult tile_predictions(const fs::path& folder,
                            const TilePlan& plan,
                            std::size_t tile,
                            const ModelLibrary& library,
                            const Catalogue& catalogue,
                            const PredictionSettings& settings,
                            int digits,
                            const std::string& key) {
  require_tile(plan, tile);
  require_rows_alone(settings, plan);
  const fs::path file = result_file(folder, "predict", plan.tiles[tile]);
  const std::string own_key = key_of(plan, "predict", {key, settings_json(settings), digits});
  if (auto earlier = earlier_result(file, own_key)) return std::move(*earlier);
  const TileRows rows = read_tile(folder, plan, tile, true);
  PredictionSettings own = settings;
  own.reading = plan.settings.reading;
  const data::TableSource table = rows.table;
  const AddedColumns columns{.table = new_columns(predict_table(table, library, catalogue, own)),
                             .digits = digits};
  refuse_known_columns(columns.table.names(), plan.head.header, plan.inventory);
  ResultRows result;
  write_rows_with_columns(
      table, columns, own.reading, [&](std::size_t line, std::string_view record) {
        line == 0 ? result.set_header(record) : result.add(line, record);
      });
  return result.write(file, own_key);
}

TileResult tile_scene(const fs::path& folder,
                      const TilePlan& plan,
                      std::size_t tile,
                      const tree::BuilderCatalogue& catalogue,
                      const GrowSettings& settings,
                      const std::string& key,
                      const Callbacks& callbacks) {
  require_tile(plan, tile);
  if (!settings.scene.empty() || !settings.out.empty() || settings.resolve_overlaps ||
      !settings.by.empty() || settings.levels.size() != 1) {
    throw UsageError("a tile has one scene, of one level of detail and without other tiles' trees");
  }
  const fs::path file = result_file(folder, "grow", plan.tiles[tile]);
  const std::string own_key = key_of(plan, "grow", key);
  if (auto earlier = earlier_result(file, own_key)) return std::move(*earlier);
  const TileRows rows = read_tile(folder, plan, tile, true);
  GrowSettings own = settings;
  own.reading = plan.settings.reading;
  const tree::SceneFormat format = settings.format.value_or(tree::SceneFormat::kGlb);
  own.scene = fs::path(file).replace_extension(word_of(format)).string();
  own.is_part = true;
  fs::create_directories(file.parent_path());
  const GrowResult grown = grow(rows.table, catalogue, own, callbacks);
  ResultRows result;
  result.set_header("tile,scene,trees,triangles,bytes\n");
  for (const WrittenScene& scene : grown.files) {
    // Merged tables are in the order of lines.
    result.add(tile + 1,
               fmt::format("{},{},{},{},{}\n",
                           plan.tiles[tile].name(),
                           data::csv_field(scene.name),
                           scene.trees,
                           scene.triangles,
                           scene.bytes));
    result.add_file(fs::path(scene.name).filename().string());
    for (const std::string& beside : scene.beside) {
      result.add_file(fs::path(beside).filename().string());
    }
  }
  result.set_trees(grown.morphologies.size());
  return result.write(file, own_key);
}

MergedTiles merge_tiles(const fs::path& folder,
                        const TilePlan& plan,
                        const std::string& command,
                        std::ostream& stream) {
  if (command != "indices" && command != "predict" && command != "grow") {
    throw UsageError("only the results of indices, predict and grow are merged; not " + command);
  }
  MergedTiles merged;
  std::optional<std::string> key;
  for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
    const auto head = read_result_head(result_file(folder, command, plan.tiles[i]));
    if (!head) {
      merged.gaps.missing.push_back(i);
      continue;
    }
    if (!key) key = head->key;
    if (head->key != *key) merged.gaps.different.push_back(i);
    if (!is_whole_result(result_file(folder, command, plan.tiles[i]), *head)) {
      merged.gaps.damaged.push_back(i);
    }
    merged.trees += head->trees;
    merged.marked += head->marked;
    merged.halo_m = std::max(merged.halo_m, head->halo_m);
  }
  if (!merged.gaps.are_none()) return merged;
  data::OrderedRows rows(stream, true);
  bool has_header = false;
  for (const Tile& tile : plan.tiles) {
    read_result(result_file(folder, command, tile),
                [&](std::size_t line, bool is_marked, std::string_view record) {
                  if (line == 0 && std::exchange(has_header, true)) return;
                  if (merged.marked == 0) return rows.add(line, record);
                  const char* const mark = line == 0 ? "halo" : is_marked ? "too small" : "";
                  record.remove_suffix(1);
                  rows.add(line, std::string(record) + ',' + mark + '\n');
                });
  }
  rows.finish();
  return merged;
}

}  // namespace silvafit::study
