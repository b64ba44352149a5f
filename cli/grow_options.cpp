// SPDX-License-Identifier: MIT
// The options of `silvafit grow`.
#include <string>

#include "grow_command.hpp"
#include "inventory_options.hpp"
#include "setting_options.hpp"
#include "silvafit/study/grow_setting_list.hpp"

namespace silvafit::cli {

void add_grow_options(CLI::App& command, std::string& file, study::GrowSettings& options) {
  command
      .add_option(
          "morphology", file, "Inventory or predictions: a CSV file, workbook, layer or database")
      ->required()
      ->type_name("FILE.csv");
  each_setting(options, SettingOptions(command, "Trees and scenes"));
  command.get_option("--per")->needs(command.get_option("--out"));
  command.get_option("--models")->needs(command.get_option("--share"));
  command.get_option("--seconds")->needs(command.get_option("--animate"));
  add_drawn_table_options(command, options.reading);
}

}  // namespace silvafit::cli
