// SPDX-License-Identifier: MIT
// `silvafit view`: a 3D page of a stand for the browser.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/view_page.hpp"
#include "standard_output.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  CommonOptions common{};
  TableArguments table{};
  std::string source{};
  std::string trees{};
  std::string out{};
  bool does_not_open = false;
  study::ViewPageSettings settings{};
};

/// Options that are no settings of the page, which the library checks.
void check_scene_option(const CLI::Option& option, bool has_trees) {
  const std::string name = option.get_name();
  if (name == "--terrain" || name == "--seed") {
    throw UsageError("has no effect on a GLB scene, which is shown unchanged; use it in grow",
                     {.column = name});
  }
  if (!has_trees && (name == "--layer" || name == "--sql")) {
    throw UsageError("has no effect on a GLB scene without a table of its trees (--trees FILE.csv)",
                     {.column = name});
  }
}

void check(const ViewArguments& arguments, const CLI::App& command) {
  const bool is_scene = study::is_glb(arguments.source);
  if (!arguments.trees.empty() && !is_scene) {
    throw UsageError(
        "--trees is the table for a GLB scene; a folder or CSV file has its own table");
  }
  const std::string ending = fs::path(arguments.out).extension().string();
  const bool is_page =
      ending == ".html" || ending == ".htm" || ending == ".HTML" || ending == ".HTM";
  if (!arguments.out.empty() && !is_page) {
    throw UsageError("--out must end in .html or .htm, not in " + arguments.out);
  }
  if (!is_scene) return;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->count() > 0) check_scene_option(*option, !arguments.trees.empty());
  }
}

/// The number of trees on the page.
std::string trees_text(const study::View& view) {
  if (view.trees > 0) return counted(view.trees, "tree", "trees");
  if (view.unmeasured == 0) return "a scene without known trees";
  return counted(view.unmeasured, "tree", "trees") + " without measurements";
}

void run(ViewArguments& arguments, const CLI::App& command) {
  check(arguments, command);
  if (arguments.out.empty() && arguments.source.starts_with("PG:")) {
    throw UsageError("--out FILE.html is needed for the trees of a database");
  }
  const fs::path page =
      arguments.out.empty() ? study::view_page_path(arguments.source) : fs::path(arguments.out);
  refuse_same_files({{"FILE", arguments.source}, {"--trees", arguments.trees}}, {{"--out", page}});
  study::ViewPageSettings& settings = arguments.settings;
  settings.view.seed = arguments.common.seed;
  settings.view.threads = arguments.common.threads;
  if (!arguments.trees.empty()) {
    settings.trees = open_trees(arguments.trees, arguments.table, arguments.common).table;
  }
  const data::TableSource source =
      arguments.trees.empty()
          ? open_drawn_trees(arguments.source, arguments.table, settings.reading, arguments.common)
                .table
          : fs::path(arguments.source);
  const fs::path empty_page = bundled_page("scene.html");
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  Progress progress(arguments.common);
  const study::ViewPage result = study::write_view_page(
      source, catalogue, empty_page, page, settings, callbacks(arguments.common, progress));
  if (arguments.common.json) {
    print_json_value(study::json_of(result), -1);
    return;
  }
  constexpr double kMegabyte = 1e6;
  print_text("{}, {:.1f} MB, {:.2f} s: {}\n",
             trees_text(result.view),
             static_cast<double>(result.bytes) / kMegabyte,
             result.seconds,
             page.string());
  const bool is_seen = system::has_desktop() && system::is_terminal(stdout);
  if (arguments.does_not_open || !is_seen) return;
  if (!system::open_in_browser(followed(page))) {
    say(arguments.common, "The browser could not be started; open the page yourself.");
  }
}

}  // namespace

void add_view_command(CLI::App& program) {
  const auto arguments = std::make_shared<ViewArguments>();
  CLI::App& command = *program.add_subcommand("view", "Write a 3D page of a stand for the browser");
  command
      .add_option(
          "source",
          arguments->source,
          "Folder of `silvafit study`, GLB scene, or table of an inventory or predictions (CSV, "
          "workbook, layer, database)")
      ->type_name("DIR|FILE.glb|FILE.csv")
      ->required();
  command.add_option("--trees", arguments->trees, "Measurements of the trees of a GLB scene")
      ->type_name("FILE.csv");
  command
      .add_option(
          "--out",
          arguments->out,
          "Page to write (default: view.html in the folder, or the name of the file with .html)")
      ->type_name("FILE.html")
      ->group(kOutputSection);
  add_layer_options(command, arguments->table);
  add_terrain_option(command, arguments->table);
  each_setting(arguments->settings.view, SettingOptions(command, "Page"));
  add_reading_options(command, arguments->settings.reading);
  command.add_flag("--no-open", arguments->does_not_open, "Do not open the page in a browser");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit view study --plot 3");
  command.callback([arguments, &command] { run(*arguments, command); });
}

}  // namespace silvafit::cli
