// SPDX-License-Identifier: MIT
#include "shared_options.hpp"

#include <utility>

#include "help.hpp"
#include "setting_options.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/setting_list.hpp"

namespace silvafit::cli {
void add_reading_options(CLI::App& command,
                         study::ReadingSettings& settings,
                         std::vector<std::string_view> only) {
  each_setting(settings, SettingOptions(command, kInputSection, std::move(only)));
  each_setting(settings.rows, SettingOptions(command, kInputSection));
}

void add_inventory_options(CLI::App& command,
                           std::string& inventory,
                           study::ReadingSettings& settings,
                           TableArguments& table) {
  command
      .add_option("inventory",
                  inventory,
                  "Inventory with one row per tree: a CSV file; a workbook (xlsx, ods, xls), a GIS "
                  "layer of points (gpkg, shp, fgb, geojson), SQLite or PG:dbname=...")
      ->type_name("INVENTORY.csv")
      ->required();
  add_layer_options(command, table);
  add_reading_options(command, settings);
}

void add_sampling_options(CLI::App& command,
                          study::SamplingSettings& settings,
                          source::TableChoice& plots) {
  const std::string section = "Sampled plots";
  each_setting(settings, SettingOptions(command, section));
  CLI::Option* const file = command.get_option("--plots");
  CLI::Option* const layer =
      command.add_option("--plots-layer", plots.layer, "Sheet or layer of --plots")
          ->type_name("NAME")
          ->needs(file)
          ->group(section);
  command.add_option("--plots-sql", plots.sql, "Query that makes the table of plots")
      ->type_name("QUERY")
      ->needs(file)
      ->excludes(layer)
      ->group(section);
}

void add_equation_options(CLI::App& command, study::EquationSettings& settings) {
  each_setting(settings, SettingOptions(command, "Volume, biomass and carbon"));
}

void open_plots(const source::TableChoice& choice,
                const TreeTable& trees,
                const CommonOptions& common,
                study::SamplingSettings& settings) {
  if (settings.plots_file.empty()) return;
  settings.plots = open_further_table(settings.plots_file, choice, trees, common);
}

void add_unit_options(CLI::App& command, study::UnitSettings& settings) {
  each_setting(settings, SettingOptions(command, "Structural units"));
  command.get_option("--circle")->excludes(command.get_option("--window"));
}

void add_digits_option(CLI::App& command, int& digits) {
  constexpr int kAllDigits = 17;  // distinguish any two doubles
  command
      .add_option(
          "--digits", digits, "Significant digits of predictions; 17 writes all that there are")
      ->check(CLI::Range(1, kAllDigits))
      ->type_name("N")
      ->capture_default_str()
      ->group(kOutputSection);
}

void add_prediction_options(CLI::App& command, study::PredictionSettings& settings) {
  each_setting(settings, SettingOptions(command, "Predictions"));
}

}  // namespace silvafit::cli
