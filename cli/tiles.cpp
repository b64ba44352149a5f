// SPDX-License-Identifier: MIT
// silvafit tiles: inventories of whole regions, one tile at a time.
#include "silvafit/study/tiles.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/study_files.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

struct PlanArguments {
  std::string inventory{};
  std::string out{};
  study::TileSettings settings{};
  CommonOptions common{};
};

struct RunArguments {
  std::string folder{};
  std::size_t tile = 1;
  std::vector<std::string> words{};
  CommonOptions common{};
};

struct MergeArguments {
  std::string folder{};
  std::string command = "indices";
  std::string out{};
  CommonOptions common{};
};

/// The remedy for trees whose halo was too small.
std::string advice_on_halo(std::size_t marked, double halo_m, double now_m) {
  const std::string remedy = std::isfinite(halo_m)
                                 ? fmt::format("--halo {} is enough", std::ceil(halo_m) + 1.0)
                                 : fmt::format("try --halo {}", 2.0 * std::max(now_m, 1.0));
  return fmt::format("the halo is too small for {}, which are marked and have no values; {}",
                     counted(marked, "tree", "trees"),
                     remedy);
}

// ---- plan -------------------------------------------------------------------------------------

void run_plan(const PlanArguments& arguments) {
  Progress progress(arguments.common);
  const study::TilePlan plan = study::plan_tiles(arguments.inventory,
                                                 arguments.settings,
                                                 arguments.out,
                                                 callbacks(arguments.common, progress));
  progress.clear();
  if (arguments.common.json) return print_json_value(study::json_of(plan));
  std::size_t largest = 0;
  for (const study::Tile& tile : plan.tiles) {
    largest = std::max(largest, tile.trees + tile.neighbors);
  }
  std::cout << fmt::format("{} of {}; the largest has {} with its halo\n",
                           counted(plan.tiles.size(), "tile", "tiles"),
                           counted(plan.rows, "row", "rows"),
                           largest);
  finish_standard_output();
}

void add_plan_command(CLI::App& tiles) {
  const auto arguments = std::make_shared<PlanArguments>();
  CLI::App& command =
      *tiles.add_subcommand("plan", "Cut a CSV file of trees with positions into tiles");
  command.add_option("inventory", arguments->inventory, "Trees with x, y and a number each")
      ->type_name("INVENTORY.csv")
      ->required();
  study::TileSettings& settings = arguments->settings;
  each_setting(settings, SettingOptions(command, "Tiles"));
  command.add_option("--out", arguments->out, "Folder of the tiles")->type_name("DIR")->required();
  each_setting(settings.reading, SettingOptions(command, kInputSection));
  // Tiles are read at their places in the file, so that no rows are made of columns of visits.
  each_setting(settings.reading.rows, SettingOptions(command, kInputSection, {"where"}));
  add_common_options(command, arguments->common);
  add_example(command, "silvafit tiles plan inventory.csv --size 500 --halo 30 --out tiles");
  command.callback([arguments] { run_plan(*arguments); });
}

// ---- run --------------------------------------------------------------------------------------

/// A command behind `--`, with the options that a tile can have.
void parse_words(CLI::App& command, std::vector<std::string> words) {
  std::ranges::reverse(words);
  try {
    command.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    throw UsageError(fmt::format("{}: {}", command.get_name(), error.what()));
  }
}

study::TileResult run_indices(const RunArguments& arguments,
                              const study::TilePlan& plan,
                              std::vector<std::string> words) {
  study::UnitSettings settings;
  CLI::App command("", "indices");
  add_unit_options(command, settings);
  parse_words(command, std::move(words));
  study::refuse_idle_settings(settings, given_options(command));
  return study::tile_indices(
      arguments.folder, plan, arguments.tile - 1, settings, arguments.common.threads);
}

study::TileResult run_predict(const RunArguments& arguments,
                              const study::TilePlan& plan,
                              std::vector<std::string> words) {
  study::PredictionSettings settings{.threads = arguments.common.threads};
  std::string name;
  int digits = kPredictedDigits;
  CLI::App command("", "predict");
  command.add_option("library", name)->required();
  add_prediction_options(command, settings);
  add_digits_option(command, digits);
  parse_words(command, std::move(words));
  study::refuse_idle_settings(settings, given_options(command));
  const study::ModelLibrary library = study::find_library(name, data_directory() / "models");
  const study::Catalogue catalogue = study::Catalogue::load(data_directory() / "models");
  std::error_code ignored;
  const bool is_file = std::filesystem::is_regular_file(name, ignored);
  return study::tile_predictions(arguments.folder,
                                 plan,
                                 arguments.tile - 1,
                                 library,
                                 catalogue,
                                 settings,
                                 digits,
                                 is_file ? fingerprint(read_file(name)) : name);
}

study::TileResult run_grow(const RunArguments& arguments,
                           const study::TilePlan& plan,
                           std::vector<std::string> words) {
  const std::string key = fmt::format("{}", fmt::join(words, " "));
  study::GrowSettings settings;
  std::string file;
  CLI::App command("", "grow");
  add_grow_options(command, file, settings);
  // Rows and columns are those of the plan; the tile is a single file.
  const std::string others =
      "morphology --scene --out --manifest --resolve-overlaps --by --animate --seconds --plot "
      "--columns --missing --fill-down --case-sensitive --dead --alive-codes --dead-codes "
      "--cut-codes";
  for (const std::string& name : CLI::detail::split(others, ' ')) {
    command.remove_option(command.get_option(name));
  }
  parse_words(command, std::move(words));
  settings.seed = arguments.common.seed;
  settings.threads = arguments.common.threads;
  const std::string grammar = settings.grammar.empty() ? "" : read_file(settings.grammar);
  Progress progress(arguments.common);
  return study::tile_scene(arguments.folder,
                           plan,
                           arguments.tile - 1,
                           tree::BuilderCatalogue::load(data_directory() / "models"),
                           settings,
                           fmt::format("{} {} {}", key, settings.seed, fingerprint(grammar)),
                           callbacks(arguments.common, progress));
}

study::TileResult run_command(const std::string& name,
                              const RunArguments& arguments,
                              const study::TilePlan& plan,
                              std::vector<std::string> words) {
  if (name == "indices") return run_indices(arguments, plan, std::move(words));
  if (name == "predict") return run_predict(arguments, plan, std::move(words));
  if (name == "grow") return run_grow(arguments, plan, std::move(words));
  throw UsageError(
      fmt::format("'{}' cannot run on tiles; available: indices, predict, grow", name));
}

void run_tile(const RunArguments& arguments, std::vector<std::string> words) {
  if (words.empty()) throw UsageError("give a command behind --, such as -- indices --per stand");
  const study::TilePlan plan = study::read_tile_plan(arguments.folder);
  if (arguments.tile < 1 || arguments.tile > plan.tiles.size()) {
    throw UsageError(fmt::format("the tiles have the numbers 1 to {}", plan.tiles.size()),
                     {.column = "--tile"});
  }
  const std::string name = words.front();
  words.erase(words.begin());
  const study::TileResult result = run_command(name, arguments, plan, std::move(words));
  if (result.marked > 0) {
    say(arguments.common,
        "note: " + describe({.file = result.file},
                            advice_on_halo(result.marked, result.halo_m, plan.settings.halo_m)));
  }
  if (result.was_there) say(arguments.common, "note: " + result.file + " already exists");
  if (!arguments.common.json) return;
  print_json_value({{"schema", "silvafit-tile/1"},
                    {"silvafit", version()},
                    {"out", result.file},
                    {"was_there", result.was_there},
                    {"trees", result.trees},
                    {"marked", result.marked},
                    {"halo_m", number_or_null(result.halo_m)}});
}

void add_run_command(CLI::App& tiles) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App& command = *tiles.add_subcommand("run", "Run a command for one tile");
  command.add_option("folder", arguments->folder, "Folder of silvafit tiles plan")
      ->type_name("DIR")
      ->required();
  command.add_option("--tile", arguments->tile, "Number of the tile, from 1")
      ->type_name("K")
      ->required();
  add_common_options(command, arguments->common);
  command
      .add_option(
          "words", arguments->words, "indices, predict LIBRARY.json or grow, with its options")
      ->type_name("-- COMMAND ...");
  add_example(command, "silvafit tiles run tiles --tile 1 -- indices --per stand --edge none");
  command.callback([arguments] { run_tile(*arguments, arguments->words); });
}

// ---- merge ------------------------------------------------------------------------------------

[[noreturn]] void refuse_gaps(const MergeArguments& arguments,
                              const study::TilePlan& plan,
                              const study::TileGaps& gaps) {
  const bool is_missing = !gaps.missing.empty();
  const bool is_damaged = !is_missing && !gaps.damaged.empty();
  const std::vector<std::size_t>& list = is_missing   ? gaps.missing
                                         : is_damaged ? gaps.damaged
                                                      : gaps.different;
  constexpr std::size_t kShown = 20;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size() && i < kShown; ++i) {
    names.push_back(fmt::format("{} ({})", list[i] + 1, plan.tiles[list[i]].name()));
  }
  if (list.size() > kShown) names.push_back(fmt::format("{} more", list.size() - kShown));
  throw InputError(
      fmt::format("{} {}: {}; run {} again: silvafit tiles run {} --tile K -- {} ...",
                  counted(list.size(), "tile has", "tiles have"),
                  is_missing   ? "no result of " + arguments.command
                  : is_damaged ? "a result that is damaged, or whose files were removed"
                               : "a result of other settings than the first tile",
                  fmt::join(names, ", "),
                  list.size() == 1 ? "it" : "them",
                  arguments.folder,
                  arguments.command),
      {.file = arguments.folder});
}

void run_merge(const MergeArguments& arguments) {
  const study::TilePlan plan = study::read_tile_plan(arguments.folder);
  refuse_same_files({{"the inventory", plan.inventory}}, {{"--out", arguments.out}});
  const auto inside = followed(arguments.out).lexically_relative(followed(arguments.folder));
  const bool is_inside = !arguments.out.empty() && !inside.empty() && *inside.begin() != "..";
  if (is_inside && std::filesystem::exists(arguments.out)) {
    throw UsageError("is a file of the tiles, which would be overwritten; choose another name",
                     {.file = arguments.out, .column = "--out"});
  }
  std::optional<AtomicFile> file;
  if (!arguments.out.empty()) file.emplace(arguments.out);
  const study::MergedTiles merged = study::merge_tiles(
      arguments.folder, plan, arguments.command, file ? file->stream() : std::cout);
  if (!merged.gaps.are_none()) refuse_gaps(arguments, plan, merged.gaps);
  if (file) file->commit();
  if (merged.marked > 0) {
    say(arguments.common,
        "note: " + advice_on_halo(merged.marked, merged.halo_m, plan.settings.halo_m));
  }
  if (arguments.common.json) {
    print_json_value({{"schema", "silvafit-tiles-merge/1"},
                      {"silvafit", version()},
                      {"out", arguments.out},
                      {"tiles", plan.tiles.size()},
                      {"trees", merged.trees},
                      {"marked", merged.marked},
                      {"halo_m", number_or_null(merged.halo_m)}});
  } else if (!file) {
    finish_standard_output();
  }
}

void add_merge_command(CLI::App& tiles) {
  const auto arguments = std::make_shared<MergeArguments>();
  CLI::App& command = *tiles.add_subcommand("merge", "Join the results of all tiles");
  command.add_option("folder", arguments->folder, "Folder of silvafit tiles plan")
      ->type_name("DIR")
      ->required();
  command.add_option("command", arguments->command, "Whose results: indices, predict or grow")
      ->check(CLI::IsMember({"indices", "predict", "grow"}))
      ->capture_default_str();
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit tiles merge tiles indices --out indices.csv");
  command.callback([arguments, &command] {
    refuse_idle(command, "--json", !arguments->out.empty(), "--out");
    run_merge(*arguments);
  });
}

}  // namespace

void add_tiles_command(CLI::App& program) {
  CLI::App& command = *program.add_subcommand(
      "tiles", "Cut an inventory of a region into tiles, work on each, and join the results");
  command.require_subcommand(1);
  add_example(command, "silvafit tiles plan inventory.csv --size 500 --halo 30 --out tiles");
  add_plan_command(command);
  add_run_command(command);
  add_merge_command(command);
}

}  // namespace silvafit::cli
