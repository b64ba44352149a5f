// SPDX-License-Identifier: MIT
// `silvafit grow`: trees and stands as GLB, glTF, OBJ or PLY.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "standard_output.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {
namespace {

struct GrowArguments {
  std::string file{};
  study::GrowSettings settings{};
  TableArguments table{};
  CommonOptions common{};
};

/// Such as ", with trees.mtl, bark.png, leaf.png and 2 more in the same folder"; empty for a single
/// file.
std::string beside_text(const study::WrittenScene& written) {
  if (written.beside.empty()) return {};
  constexpr std::size_t kNamed = 3;
  const std::size_t named = std::min(kNamed, written.beside.size());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < named; ++i) {
    names.push_back(std::filesystem::path(written.beside[i]).filename().string());
  }
  const std::size_t more = written.beside.size() - named;
  return fmt::format(", with {}{} in the same folder",
                     fmt::join(names, ", "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

/// The written files: one file in one line, several files each in its own line.
void print_files(const study::GrowResult& result) {
  const std::string stand = counted(result.counts.trees, "tree", "trees");
  if (result.files.size() == 1) {
    const study::WrittenScene& only = result.files.front();
    print_text("{}, {} triangles, {:.2f} s: {}{}\n",
               stand,
               only.triangles,
               result.seconds,
               only.name,
               beside_text(only));
    return;
  }
  const std::string times = result.moments > 1 ? fmt::format(" at {} times", result.moments) : "";
  print_text("{}{}, {:.2f} s:\n", stand, times, result.seconds);
  constexpr std::size_t kShown = 40;
  for (std::size_t i = 0; i < std::min(kShown, result.files.size()); ++i) {
    const study::WrittenScene& one = result.files[i];
    print_text("  {}: {}, {} triangles{}\n",
               one.name,
               counted(one.trees, "tree", "trees"),
               one.triangles,
               beside_text(one));
  }
  if (result.files.size() > kShown) {
    print_text("  ... and {} more; use {} to list all\n",
               result.files.size() - kShown,
               result.settings.stream ? "--manifest" : "--json");
  }
}

/// Prints the result as text or as JSON.
void report_grown(const CommonOptions& common, const study::GrowResult& result) {
  if (common.json) {
    print_json_value(study::json_of(result), -1);
    return;
  }
  const study::GrowCounts& counts = result.counts;
  const std::string how = result.settings.stream ? "." : "; use --json to list them.";
  print_files(result);
  if (result.settings.share) {
    const tree::ShapeError worst = study::worst_of(result.shared);
    print_text("{}; largest errors: crown base {:.0f} cm, DBH {:.1f} cm, crown radius {:.0f} cm\n",
               counted(result.shared.models.size(), "model", "models"),
               worst.hcb_cm,
               worst.dbh_cm,
               worst.radius_cm);
  }
  if (result.settings.resolve_overlaps)
    print_text("{} overlapped\n", counted(counts.overlaps, "pair of crowns", "pairs of crowns"));
  if (counts.crossing > 0) {
    say(common,
        counted(counts.crossing, "tree is", "trees are") +
            " too close to others to separate all branches" + how);
  }
  if (counts.with_guesses > 0) {
    std::vector<std::string> replaced;
    for (const auto& [name, count] : counts.guesses) {
      replaced.push_back(fmt::format("{} of {}", name, count));
    }
    say(common,
        fmt::format("{} measurements that are missing or contradict others, for which defaults or "
                    "the others are used ({}){}",
                    counted(counts.with_guesses, "tree has", "trees have"),
                    fmt::join(replaced, ", "),
                    how));
  }
}

void run(const GrowArguments& arguments) {
  study::GrowSettings settings = arguments.settings;
  std::vector<NamedFile> written{{"--scene", settings.scene}, {"--manifest", settings.manifest}};
  // The buffer of glTF and the materials of OBJ are beside the scene.
  const std::filesystem::path scene(settings.scene);
  for (const auto& [ending, beside] : {std::pair(".gltf", ".bin"), std::pair(".obj", ".mtl")}) {
    if (scene.extension() != ending) continue;
    written.push_back(
        {"a file beside --scene", std::filesystem::path(scene).replace_extension(beside)});
  }
  refuse_same_files({{"MORPHOLOGY.csv", arguments.file}, {"--grammar", settings.grammar}}, written);
  if (is_layer_output(settings.manifest)) {
    throw UsageError("is a CSV file, not a workbook or layer", {.column = "--manifest"});
  }
  if (settings.stream && arguments.common.json) {
    throw UsageError("--json has an entry for each tree; with --stream, use --manifest FILE.csv",
                     {.column = "--stream"});
  }
  settings.keeps_trees = arguments.common.json;
  settings.seed = arguments.common.seed;
  settings.threads = arguments.common.threads;
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  const TreeTable trees =
      open_drawn_trees(arguments.file, arguments.table, settings.reading, arguments.common);
  Progress progress(arguments.common);
  const study::GrowResult result =
      study::grow(trees.table, catalogue, settings, callbacks(arguments.common, progress));
  progress.clear();
  report_grown(arguments.common, result);
}

}  // namespace

void add_grow_command(CLI::App& program) {
  auto arguments = std::make_shared<GrowArguments>();
  CLI::App* command =
      program.add_subcommand("grow", "Grow measured or predicted trees as 3D models");
  add_grow_options(*command, arguments->file, arguments->settings);
  command->add_flag(
      "--stream",
      arguments->settings.stream,
      "With --out: write trees while others are read, so that memory does not grow with their "
      "number; if the rows of a plot are not contiguous, they are sorted on disk first");
  add_layer_options(*command, arguments->table);
  add_terrain_option(*command, arguments->table);
  add_common_options(*command, arguments->common);
  add_example(*command,
              "silvafit grow examples/fir-mixed/inventory.csv --plot 1 --scene plot1.glb");
  command->callback([arguments, command] {
    const bool has_ground = arguments->settings.out.empty() || arguments->settings.is_by_plot;
    for (const char* const option : {"--ground", "--terrain"}) {
      refuse_idle(*command, option, has_ground, "--scene or --per plot");
    }
    run(*arguments);
  });
}

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
  add_reading_options(command, options.reading);
}

}  // namespace silvafit::cli
