// SPDX-License-Identifier: MIT
#include "silvafit/study/structure_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <functional>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::study {
namespace {

constexpr std::array<std::string_view, 6> kUnitNames{"W", "M", "U", "C", "core", "weight"};

struct PlotColumn {
  std::string_view name;
  double stand::StandFigures::*member;
};

constexpr std::array<PlotColumn, 4> kPlotColumns{
    {{"stems_per_ha", &stand::StandFigures::stems_per_ha},
     {"basal_area_per_ha", &stand::StandFigures::basal_area_m2_per_ha},
     {"quadratic_mean_dbh", &stand::StandFigures::quadratic_mean_dbh_cm},
     {"dominant_height", &stand::StandFigures::dominant_height_m}}};

bool is_unit_name(std::string_view name) {
  return std::ranges::find(kUnitNames, name) != kUnitNames.end();
}

const PlotColumn* plot_column(std::string_view name) {
  const auto* const found = std::ranges::find(kPlotColumns, name, &PlotColumn::name);
  return found == kPlotColumns.end() ? nullptr : found;
}

bool has_numbers(const data::Table& table, std::string_view name) {
  return table.has(name) && table.is_numeric(name);
}

bool has_stand(const data::Table& table) {
  return has_numbers(table, "x") && has_numbers(table, "y") && has_numbers(table, "dbh");
}

std::vector<double> numbers_or_none(const data::Table& table, std::string_view name) {
  if (!has_numbers(table, name)) return {};
  const std::span<const double> values = table.numbers(name);
  return {values.begin(), values.end()};
}

data::TextColumn labels_or(const data::Table& table,
                           std::string_view name,
                           const std::function<std::string(std::size_t)>& otherwise) {
  data::TextColumn column;
  const data::TextColumn given = table.has(name) ? table.labels(name) : data::TextColumn();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_given = table.has(name) && !given.is_missing(row);
    column.append(is_given ? std::string(given[row]) : otherwise(row));
  }
  return column;
}

stand::Inventory inventory_of(const data::Table& table) {
  stand::Inventory inventory;
  inventory.file = table.file();
  inventory.plot = labels_or(table, "plot", [](std::size_t) { return "1"; });
  inventory.tree =
      labels_or(table, "tree", [](std::size_t row) { return fmt::format("{}", row + 1); });
  for (const stand::TreeColumn& column : stand::tree_columns()) {
    if (column.is_measure()) inventory.*column.values = numbers_or_none(table, column.name);
  }
  const data::TextColumn species =
      table.has("species") ? table.labels("species") : data::TextColumn();
  const data::TextColumn plots = table.has("plot") ? table.labels("plot") : data::TextColumn();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_named = table.has("species") && !species.is_missing(row);
    is_named ? inventory.species.append(species[row]) : inventory.species.append_missing();
    const bool has_plot = !table.has("plot") || !plots.is_missing(row);
    if (!has_plot) inventory.x[row] = data::kMissing;
    const bool has_size = inventory.dbh_cm[row] > 0.0;
    if (!has_size) inventory.dbh_cm[row] = data::kMissing;
    inventory.neighbor_only.push_back(has_size ? 0 : 1);
  }
  return inventory;
}

std::vector<double> unit_column(const stand::StructuralUnits& units, std::string_view name) {
  const std::size_t trees = units.core.size();
  if (name == "W") return units.W;
  if (name == "M") return units.M;
  if (name == "U") return units.U;
  if (name == "C") return units.C.empty() ? std::vector<double>(trees, data::kMissing) : units.C;
  if (name == "core") return {units.core.begin(), units.core.end()};
  if (name == "weight") {
    std::vector<double> weights;
    for (std::size_t tree = 0; tree < trees; ++tree) weights.push_back(units.weight_of(tree));
    return weights;
  }
  const auto further = std::ranges::find(
      units.further, find_word<stand::FurtherIndex>(name), &stand::FurtherValues::index);
  return further->values;
}

void add_columns_of_windows(const std::vector<std::string>& names,
                            const stand::Inventory& inventory,
                            const stand::StructuralUnitOptions& options,
                            data::Table& table,
                            std::vector<std::string>& notes) {
  const stand::PlotWindows windows = stand::plot_windows(inventory, options.windows, options.scope);
  if (windows.is_assumed) {
    notes.emplace_back("per-hectare values use convex hulls, which are smaller than the plots");
  }
  add_plot_columns(names, inventory, stand::sampled_areas(inventory, windows, {}), table);
}

/// The name at a position in a text; moves the position behind it.
std::string name_at(const std::string& text, std::size_t& place) {
  const auto is_part = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '.'; };
  const std::size_t begin = place;
  while (place < text.size() && is_part(static_cast<unsigned char>(text[place]))) ++place;
  return text.substr(begin, place - begin);
}

/// Names in a text, except those in quotes and those of functions.
std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t place = 0; place < text.size();) {
    if (text[place] == '"' || text[place] == '\'') {
      const std::size_t end = text.find(text[place], place + 1);
      place = end == std::string::npos ? text.size() : end + 1;
      continue;
    }
    if (std::isalnum(static_cast<unsigned char>(text[place])) == 0 && text[place] != '_') {
      ++place;
      continue;
    }
    std::string name = name_at(text, place);
    const std::size_t next = text.find_first_not_of(' ', place);
    const bool is_function = next != std::string::npos && text[next] == '(';
    if (!is_function) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

bool is_plot_value_name(std::string_view name) { return plot_column(name) != nullptr; }

bool is_structure_name(std::string_view name) {
  return is_unit_name(name) || find_word<stand::FurtherIndex>(name).has_value() ||
         plot_column(name) != nullptr;
}

bool is_of_neighbors(std::string_view name) {
  const auto further = find_word<stand::FurtherIndex>(name);
  return is_unit_name(name) || (further && *further != stand::FurtherIndex::kBasalAreaLarger &&
                                *further != stand::FurtherIndex::kCrownCompetition);
}

std::vector<std::string> structure_names_in(const std::vector<std::string>& texts,
                                            const data::Table& table) {
  std::vector<std::string> wanted;
  if (!has_stand(table)) return wanted;
  for (const std::string& text : texts) {
    for (std::string& name : names_in(text)) {
      const bool is_new = std::ranges::find(wanted, name) == wanted.end();
      if (is_new && is_structure_name(name) && !table.has(name)) wanted.push_back(std::move(name));
    }
  }
  return wanted;
}

std::vector<std::string> add_structure_columns(const std::vector<std::string>& names,
                                               data::Table& table,
                                               stand::StructuralUnitOptions options) {
  std::vector<std::string> wanted;
  bool needs_units = false;
  bool needs_plots = false;
  options.further.clear();
  for (const std::string& name : names) {
    if (!is_structure_name(name)) {
      throw UsageError(fmt::format("'{}' is not a structural index", name));
    }
    if (table.has(name)) continue;
    wanted.push_back(name);
    const auto further = find_word<stand::FurtherIndex>(name);
    if (further) options.further.push_back(*further);
    needs_units = needs_units || further || is_unit_name(name);
    needs_plots = needs_plots || plot_column(name) != nullptr;
  }
  std::vector<std::string> notes;
  if (wanted.empty()) return notes;
  if (!has_stand(table)) {
    throw InputError(fmt::format("{} can be computed from columns x, y and dbh; the columns are {}",
                                 fmt::join(wanted, ", "),
                                 data::list_of(table.names())),
                     {.file = table.file()});
  }
  if (needs_units && options.edge == stand::EdgeCorrection::kTorus && options.windows.empty()) {
    throw InputError(fmt::format("{} of the study are of a torus, whose window is not known here; "
                                 "use its predictions.csv, which has them",
                                 fmt::join(wanted, ", ")),
                     {.file = table.file()});
  }
  const stand::Inventory inventory = inventory_of(table);
  if (needs_units) {
    const stand::StructuralUnits units = stand::structural_units(inventory, options);
    notes = units.notes;
    for (const std::string& name : wanted) {
      if (plot_column(name) == nullptr) table.set(name, unit_column(units, name));
    }
  }
  if (needs_plots) add_columns_of_windows(wanted, inventory, options, table, notes);
  return notes;
}

void add_plot_columns(const std::vector<std::string>& names,
                      const stand::Inventory& inventory,
                      const std::vector<stand::SampledArea>& areas,
                      data::Table& table) {
  for (const std::string& name : names) {
    const PlotColumn* column = plot_column(name);
    if (column == nullptr || table.has(name)) continue;
    std::vector<double> values(table.rows(), data::kMissing);
    for (const stand::SampledArea& area : areas) {
      const double value =
          stand::stand_figures(inventory, area.trees, area.area_m2).*(column->member);
      for (const std::size_t tree : area.trees) values[tree] = value;
    }
    table.set(name, std::move(values));
  }
}

}  // namespace silvafit::study
