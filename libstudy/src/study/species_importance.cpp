// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <limits>
#include <string>
#include <vector>

#include "silvafit/stand/species_table.hpp"
#include "silvafit/stand/stand_summary.hpp"
#include "study/study_tables.hpp"

namespace silvafit::study {
namespace {

/// A missing number: an empty cell.
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Each layer has two columns, from the highest layer down: the importance value and its standard
/// deviation between plots.
void add_layer_columns(const stand::Layers& layers, FormattedTable& table) {
  for (std::size_t layer = layers.count(); layer-- > 0;) {
    const std::string name = layers.name_of(layer);
    table.columns.push_back({fmt::format("importance_{}", name),
                             fmt::format("IV, {} layer (%)", name),
                             ColumnKind::kPercent});
    table.columns.push_back(
        {fmt::format("importance_{}_sd", name), "SD of IV", ColumnKind::kPercent});
  }
}

std::vector<stand::SampledArea> areas_of(const StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  if (record.sample) return record.sample->areas;
  std::vector<stand::SampledArea> areas;
  if (record.stand) {
    for (const stand::AreaReport& report : record.stand->areas) areas.push_back(report.area);
    return areas;
  }
  if (record.units) areas = stand::sampled_areas(inventory, record.units->windows, {});
  return areas.empty() ? stand::plots_of_unknown_area(inventory) : areas;
}

TableRow row_of(const stand::SpeciesRow& row, const stand::Layers& layers) {
  TableRow cells{row.species,
                 static_cast<double>(row.figures.trees),
                 row.figures.stems_per_ha,
                 row.all.relative_density,
                 row.all.relative_frequency,
                 row.all.relative_dominance};
  for (std::size_t layer = layers.count(); layer-- > 0;) {
    const bool is_known = layer < row.layers.size();
    cells.emplace_back(is_known ? row.layers[layer].value : kUnknown);
    cells.emplace_back(is_known ? row.layers[layer].plot_sd : kUnknown);
  }
  const TableRow sizes{row.all.value,
                       row.all.plot_sd,
                       row.figures.mean_dbh_cm,
                       row.figures.sd_dbh_cm,
                       row.figures.mean_height_m,
                       row.figures.sd_height_m,
                       row.figures.basal_area_m2_per_ha,
                       row.figures.dominant_height_m};
  cells.insert(cells.end(), sizes.begin(), sizes.end());
  return cells;
}

}  // namespace

FormattedTable species_importance_table(const StudyRecord& record) {
  const stand::Layers layers;
  const stand::Inventory& inventory = record.inventory.inventory;
  const std::vector<stand::SampledArea> areas = areas_of(record);
  const double quadrat_m = stand::usual_quadrat_m(inventory.plot.levels().size() == 1, areas);
  FormattedTable table{
      .name = "species",
      .caption = fmt::format(
          "Species with their importance values (IV, the mean of relative density, frequency and "
          "dominance) in each layer and in all. {}. SD of IV: standard deviation between plots; "
          "of DBH and height: between trees",
          stand::describe_frequency(quadrat_m)),
      .columns = {{"species", "Species"},
                  {"trees", "Trees", ColumnKind::kCount},
                  {"stems_per_ha", "Stems per ha", ColumnKind::kPercent},
                  {"relative_density", "Rel. density (%)", ColumnKind::kPercent},
                  {"relative_frequency", "Rel. frequency (%)", ColumnKind::kPercent},
                  {"relative_dominance", "Rel. dominance (%)", ColumnKind::kPercent}}};
  add_layer_columns(layers, table);
  const std::vector<TableColumn> sizes{
      {"importance", "IV, all (%)", ColumnKind::kPercent},
      {"importance_sd", "SD of IV", ColumnKind::kPercent},
      {"mean_dbh", "Mean DBH (cm)", ColumnKind::kCriterion},
      {"sd_dbh", "SD of DBH", ColumnKind::kCriterion},
      {"mean_height", "Mean height (m)", ColumnKind::kCriterion},
      {"sd_height", "SD of height", ColumnKind::kCriterion},
      {"basal_area_per_ha", "Basal area (m\u00B2/ha)", ColumnKind::kCriterion},
      {"dominant_height", "Dominant height (m)", ColumnKind::kCriterion}};
  table.columns.insert(table.columns.end(), sizes.begin(), sizes.end());
  for (const stand::SpeciesRow& row :
       stand::species_table(inventory, areas, {.layers = layers, .quadrat_m = quadrat_m})) {
    table.rows.push_back(row_of(row, layers));
  }
  return table;
}

}  // namespace silvafit::study
