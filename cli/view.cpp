// SPDX-License-Identifier: MIT
// `silvafit view`: a 3D page of a stand for the browser.
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "name_list.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/report_page.hpp"
#include "silvafit/study/view_data.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "standard_output.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct ViewArguments {
  CommonOptions common{};
  std::string source{};
  std::string trees{};
  std::string out{};
  std::vector<std::string> columns{};
  bool does_not_open = false;
  bool chooses_models = false;  ///< --models or --lod is given
  SheetArguments sheet{};
  study::ViewOptions options{};
  std::vector<std::string> recognized{};  ///< how the table was read
};

/// The folder or file name without its parent path.
std::string name_of(const fs::path& source) { return followed(source).filename().string(); }

/// By its ending, or by its first bytes.
bool is_glb(const fs::path& file) {
  if (file.extension() == ".glb" || file.extension() == ".GLB") return true;
  if (kind_of(file) != PathKind::kFile) return false;
  std::string magic(4, '\0');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(magic.data(), 4) && magic == "glTF";
}

/// Whether a file name has the ending of a table, or none.
bool is_called_table(const fs::path& file) {
  const std::string ending = file.extension().string();
  return ending.empty() || ending == ".csv" || ending == ".CSV" || ending == ".txt";
}

/// The table of some trees.
data::Table read_trees(const fs::path& file, ViewArguments& arguments) {
  ReadTable read =
      read_tree_table(file, arguments.options.columns, arguments.sheet, arguments.common);
  arguments.recognized = std::move(read.recognized);
  return std::move(read.table);
}

/// The table of trees to show, or an error with the supported inputs.
data::Table table_of(const fs::path& file, ViewArguments& arguments) {
  try {
    return read_trees(file, arguments);
  } catch (const InputError& error) {
    if (is_called_table(file) || !is_there(file)) throw;
    throw InputError(fmt::format("not a folder of `silvafit study`, a GLB scene or a CSV table of "
                                 "trees (as a table: {})",
                                 error.message()),
                     {.file = file.string()});
  }
}

void check(const ViewArguments& arguments) {
  const bool is_scene = is_glb(arguments.source);
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
  const bool has_choice = !arguments.options.plots.empty() || !arguments.columns.empty();
  if (is_scene && arguments.trees.empty() && has_choice) {
    throw UsageError("--plot and --columns need a table of trees; add --trees FILE.csv");
  }
  if (is_scene && arguments.chooses_models) {
    throw UsageError(
        "--models and --lod cannot be used with a GLB scene, which is shown unchanged");
  }
}

study::View view_of_file(ViewArguments& arguments, const tree::PresetCatalogue& catalogue) {
  const fs::path source = arguments.source;
  if (kind_of(source) == PathKind::kFolder) {
    const fs::path predictions = source / "predictions.csv";
    if (!is_there(predictions)) {
      throw InputError("not a folder of `silvafit study`: it contains no predictions.csv",
                       {.file = source.string()});
    }
    const data::Table trees = read_trees(predictions, arguments);
    return study::view_of_trees(trees, catalogue, arguments.options);
  }
  if (is_glb(source)) {
    std::optional<data::Table> table;
    if (!arguments.trees.empty()) {
      table = read_trees(arguments.trees, arguments);
    }
    try {
      return study::view_of_scene(read_file(source, tree::kLargestScene),
                                  table ? &*table : nullptr,
                                  catalogue,
                                  arguments.options);
    } catch (const InputError& error) {
      if (!error.place().file.empty()) throw;
      throw InputError(error.message(), {.file = source.string()});
    }
  }
  if (source.extension() == ".gltf") {
    throw InputError("glTF with separate buffer files is not supported; use a .glb file",
                     {.file = source.string()});
  }
  const data::Table trees = table_of(source, arguments);
  return study::view_of_trees(trees, catalogue, arguments.options);
}

/// The page's path: in the folder, or next to the file.
fs::path page_path(const ViewArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  const fs::path source = arguments.source;
  if (kind_of(source) == PathKind::kFolder) return source / "view.html";
  return fs::path(source).replace_extension(".html");
}

bool has_desktop() {
  const auto is_set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY")) && ::isatty(STDOUT_FILENO) == 1;
}

/// Opens the page on the desktop. \return whether this succeeded
bool open_in_browser(const fs::path& page) {
  std::string program = "xdg-open";
  std::string file = followed(page).string();
  std::vector<char*> words{program.data(), file.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, program.c_str(), nullptr, nullptr, words.data(), environ) != 0) {
    return false;
  }
  int status = 0;
  return ::waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The number of trees on the page.
std::string trees_text(const study::View& view) {
  if (view.trees > 0) return counted(view.trees, "tree", "trees");
  if (view.unmeasured == 0) return "a scene without known trees";
  return counted(view.unmeasured, "tree", "trees") + " without measurements";
}

void report(const ViewArguments& arguments,
            const study::View& view,
            const fs::path& page,
            double seconds) {
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < std::min(kShown, view.left_out.size()); ++i) {
    say(arguments.common,
        describe(view.left_out[i].place, view.left_out[i].reason + "; the row is skipped"));
  }
  if (view.left_out.size() > kShown) {
    say(arguments.common,
        fmt::format("... and {} skipped",
                    counted(view.left_out.size() - kShown, "more row is", "more rows are")));
  }
  for (const std::string& note : view.notes) say(arguments.common, note);
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(page, unknown);
  const std::size_t bytes = unknown ? 0 : size;
  if (arguments.common.json) {
    print_json_value({{"schema", "silvafit-view-command/1"},
                      {"silvafit", version()},
                      {"page", page.string()},
                      {"bytes", bytes},
                      {"trees", view.trees},
                      {"unmeasured", view.unmeasured},
                      {"variants", view.variants},
                      {"models", view.models},
                      {"left_out", view.left_out.size()},
                      {"recognized", arguments.recognized},
                      {"notes", view.notes},
                      {"seconds", seconds}},
                     -1);
    return;
  }
  constexpr double kMegabyte = 1e6;
  print_text("{}, {:.1f} MB, {:.2f} s: {}\n",
             trees_text(view),
             static_cast<double>(bytes) / kMegabyte,
             seconds,
             page.string());
}

void run(ViewArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  check(arguments);
  refuse_same_files({{"FILE", arguments.source}, {"--trees", arguments.trees}},
                    {{"--out", page_path(arguments)}});
  study::ViewOptions& options = arguments.options;
  options.columns = column_map(arguments.columns);
  options.version = version();
  options.seed = arguments.common.seed;
  options.threads = arguments.common.threads;
  if (options.title.empty()) options.title = name_of(arguments.source);
  std::sort(options.levels.begin(), options.levels.end());
  options.levels.erase(std::unique(options.levels.begin(), options.levels.end()),
                       options.levels.end());
  const fs::path empty_page = bundled_page("scene.html");
  const auto catalogue = tree::PresetCatalogue::load(data_directory() / "models");
  const study::View view = view_of_file(arguments, catalogue);
  const fs::path page = page_path(arguments);
  study::write_report_page(empty_page, view.data, options.title, page);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report(arguments, view, page, seconds.count());
  if (arguments.does_not_open || arguments.common.json || !has_desktop()) return;
  if (!open_in_browser(page)) {
    say(arguments.common, "The browser could not be started; open the page yourself.");
  }
}

}  // namespace

void add_view_command(CLI::App& program) {
  const auto arguments = std::make_shared<ViewArguments>();
  CLI::App& command = *program.add_subcommand("view", "Write a 3D page of a stand for the browser");
  command
      .add_option("source",
                  arguments->source,
                  "Folder of `silvafit study`, GLB scene, or CSV of an inventory or predictions")
      ->type_name("DIR|FILE.glb|FILE.csv")
      ->required();
  command.add_option("--trees", arguments->trees, "Measurements of the trees of a GLB scene")
      ->type_name("FILE.csv");
  command
      .add_option(
          "--out",
          arguments->out,
          "Page to write (default: view.html in the folder, or the name of the file with .html)")
      ->type_name("FILE.html");
  add_names_option(command, "--plot", arguments->options.plots, "Show these plots only");
  command.add_option("--title", arguments->options.title, "Headline (default: the name)");
  add_columns_option(command, arguments->columns);
  add_sheet_options(command, arguments->sheet);
  add_dead_option(command, arguments->sheet);
  const CLI::Option* models =
      command
          .add_option("--models",
                      arguments->options.models_per_preset,
                      "Number of models that the trees of a species preset share")
          ->capture_default_str();
  const CLI::Option* levels =
      command
          .add_option(
              "--lod", arguments->options.levels, "Levels of detail in the page, 0 (finest) to 3")
          ->delimiter(',')
          ->capture_default_str();
  command.add_flag("--no-open", arguments->does_not_open, "Do not open the page in a browser");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit view study --plot 3");
  command.callback([arguments, models, levels] {
    arguments->chooses_models = models->count() > 0 || levels->count() > 0;
    run(*arguments);
  });
}

}  // namespace silvafit::cli
