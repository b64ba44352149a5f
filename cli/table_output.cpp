// SPDX-License-Identifier: MIT
#include "table_output.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/study/rows_with_columns.hpp"

namespace silvafit::cli {
namespace {

bool is_position(const std::string& name) { return name == "x" || name == "y"; }

/// Adds x and y if the table has them under other names, in other units, or through --columns.
void add_positions(data::Table& table, const study::ReadingSettings& reading) {
  std::vector<stand::ColumnMapping> mappings = stand::parse_column_mappings(reading.columns);
  std::erase_if(mappings, [](const auto& mapping) { return !is_position(mapping.name); });
  const auto is_wanted = [&](const std::string& name) {
    return is_position(name) &&
           std::ranges::find(mappings, name, &stand::ColumnMapping::name) == mappings.end();
  };
  const auto usual = stand::usual_columns(table.names(), is_wanted, table.file());
  mappings.insert(mappings.end(), usual.begin(), usual.end());
  const data::Table read = table;
  for (const stand::ColumnMapping& mapping : mappings) {
    table.set(mapping.name, stand::numbers_from(read, mapping.name, mapping.source));
  }
}

/// The polygons of a window in well-known text.
std::string wkt_of(const stand::Window& window) {
  const auto ring_text = [](const std::vector<stand::Point>& ring) {
    std::string text = "(";
    const auto add = [&text](const stand::Point& point) {
      if (text.size() > 1) text += ", ";
      text += fmt::format("{} {}", point.x, point.y);
    };
    for (const stand::Point& point : ring) add(point);
    const bool is_closed = ring.front().x == ring.back().x && ring.front().y == ring.back().y;
    if (!is_closed) add(ring.front());
    return text + ")";
  };
  std::vector<std::string> polygons;
  for (const stand::Polygon& polygon : window.outline()) {
    std::vector<std::string> rings{ring_text(polygon.outer)};
    for (const auto& hole : polygon.holes) rings.push_back(ring_text(hole));
    polygons.push_back(fmt::format("({})", fmt::join(rings, ", ")));
  }
  return fmt::format("MULTIPOLYGON ({})", fmt::join(polygons, ", "));
}

}  // namespace

bool is_layer_output(const std::string& out) { return source::is_written_as_layers(out); }

void require_table_output(const std::string& out) {
  if (is_layer_output(out)) return source::require_layer_output(out);
  const std::string ending = in_lower_case(std::filesystem::path(out).extension().string());
  if (source::is_layered(out) || has_word(".tsv .json .gz .zip .bz2 .xz .parquet .rds", ending)) {
    throw UsageError(
        "tables are written as .csv, .xlsx, .ods, .gpkg or .fgb; choose one of these endings",
        {.file = out});
  }
}

data::Table table_of_csv(std::string text,
                         const std::string& file,
                         const study::ReadingSettings& reading) {
  data::Table table = study::labeled_table(std::move(text), file);
  add_positions(table, reading);
  return table;
}

void write_table(const std::string& out, const std::string& name, data::Table table) {
  if (!is_layer_output(out)) return data::write_csv_table(table, out);
  source::write_layers(out, {{.name = name, .table = std::move(table)}}, std::nullopt);
}

std::optional<source::Layer> plot_layer(const stand::Inventory& inventory,
                                        const stand::PlotWindows& windows) {
  if (windows.domains.empty()) return std::nullopt;
  std::vector<double> trees(windows.domains.size(), 0.0);
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    const auto domain = windows.domain_of_plot[inventory.plot.code(i)];
    if (domain) trees[*domain] += 1.0;
  }
  data::TextColumn plot;
  data::TextColumn wkt;
  std::vector<double> area;
  for (const stand::Domain& domain : windows.domains) {
    domain.name.empty() ? plot.append_missing() : plot.append(domain.name);
    wkt.append(wkt_of(domain.window));
    area.push_back(domain.window.area_m2());
  }
  source::Layer layer{.name = "plots",
                      .geometry = source::LayerGeometry::kAreas,
                      .style = source::LayerStyle::kPlotOutlines};
  layer.table.set("plot", std::move(plot));
  layer.table.set("area_m2", std::move(area));
  layer.table.set("trees", std::move(trees));
  layer.table.set("wkt", std::move(wkt));
  return layer;
}

void write_trees(const std::string& out,
                 data::Table trees,
                 std::optional<source::Layer> plots,
                 const std::optional<source::CoordinateSystem>& coordinates,
                 const CommonOptions& common) {
  const bool has_positions =
      trees.has("x") && trees.has("y") && trees.is_numeric("x") && trees.is_numeric("y");
  const bool is_map = source::has_geometries(out);
  if (is_map && !has_positions) {
    say(common, "note: " + describe({.file = out}, "the trees have no x and y, and no geometry"));
  }
  std::vector<source::Layer> layers;
  layers.push_back({.name = "trees",
                    .table = std::move(trees),
                    .geometry = is_map && has_positions ? source::LayerGeometry::kPoints
                                                        : source::LayerGeometry::kNone,
                    .style = source::LayerStyle::kTreesBySpecies});
  if (plots && is_map) layers.push_back(std::move(*plots));
  source::write_layers(out, layers, coordinates);
}

void write_sheets_of_folder(const std::string& out, const std::filesystem::path& folder) {
  std::vector<source::Layer> sheets;
  for (const std::filesystem::path& part : {folder / "tables", folder}) {
    for (const std::filesystem::path& file : files_in_folder(part, ".csv")) {
      sheets.push_back({.name = file.stem().string(),
                        .table = table_of_csv(read_file(file, kAnySize), file.string(), {})});
    }
  }
  source::write_layers(out, sheets, std::nullopt);
}

}  // namespace silvafit::cli
