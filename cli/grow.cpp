// SPDX-License-Identifier: MIT
// `silvafit grow`: trees and stands as GLB.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/tree/morphology_table.hpp"
#include "silvafit/tree/scene.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct GrowCommand {
  CommonOptions common;
  std::string file;
  std::string use = "observed";
  std::string preset;
  std::string scene;
  std::string out;
  std::string builder = "segment";
  std::string format = "glb";
  std::vector<std::string> plots;
  std::vector<std::string> columns;
};

/// What is reported of one tree.
struct GrownTree {
  tree::SceneTree tree{};
  std::string file{};
  std::size_t bytes = 0;
};

std::map<std::string, std::string> column_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> map;
  for (const std::string& entry : entries) {
    const std::size_t equals = entry.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == entry.size()) {
      throw UsageError("--columns takes name=expression, not " + entry);
    }
    map[entry.substr(0, equals)] = entry.substr(equals + 1);
  }
  return map;
}

tree::MorphologyTable read_trees(const GrowCommand& command) {
  const tree::MorphologyTableOptions options{.use = tree::use_from_text(command.use),
                                             .columns = column_map(command.columns),
                                             .plots = command.plots,
                                             .needs_position = !command.scene.empty()};
  data::CsvTableOptions csv{.text_columns = {"plot", "tree", "species"}};
  for (const char* name : {"plot", "tree", "species"}) {
    const auto mapped = options.columns.find(name);
    if (mapped != options.columns.end()) csv.text_columns.push_back(mapped->second);
  }
  return tree::read_morphologies(data::read_csv_table(command.file, csv), options);
}

std::string quoted(const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
  return list;
}

/// The preset of each tree: the one that was asked for, or the species' own.
std::vector<const tree::Preset*> presets_of(const std::vector<tree::Morphology>& morphologies,
                                            const tree::PresetCatalogue& catalogue,
                                            const GrowCommand& command) {
  std::vector<const tree::Preset*> presets;
  std::set<std::string> unknown;
  for (const tree::Morphology& morphology : morphologies) {
    const tree::Preset* preset = command.preset.empty() ? catalogue.for_species(morphology.species)
                                                        : &catalogue.named(command.preset);
    if (preset == nullptr) unknown.insert(morphology.species);
    presets.push_back(preset);
  }
  if (!unknown.empty()) {
    say(command.common,
        fmt::format("No preset lists the species {}; they grow as {} (see --preset).",
                    quoted(unknown),
                    catalogue.fallback().name));
  }
  return presets;
}

/// A file name that no file system objects to; bytes beyond letters, digits, `.`, `_` and `-`
/// become %XX, so that different names stay different.
std::string file_name(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '_' || c == '-' ||
                          (c == '.' && !safe.empty());
    if (is_plain) {
      safe += c;
    } else {
      safe += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return safe + ".glb";
}

std::vector<std::string> file_names(const std::vector<tree::Morphology>& morphologies) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const tree::Morphology& morphology : morphologies) {
    std::string name = file_name(morphology.plot + "-" + morphology.tree);
    // Plot a, tree b-c and plot a-b, tree c share a name; a tilde is in no other.
    for (int copy = 2; !taken.insert(name).second; ++copy) {
      name = file_name(morphology.plot + "-" + morphology.tree);
      name.insert(name.size() - 4, fmt::format("~{}", copy));
    }
    names.push_back(std::move(name));
  }
  return names;
}

ordered_json json_of(const GrownTree& grown) {
  const tree::SceneTree& tree = grown.tree;
  const tree::Measurements& measured = tree.measured;
  ordered_json notes = ordered_json::array();
  for (const tree::Note& note : tree.notes) {
    notes.push_back({{"about", note.about}, {"text", note.text}});
  }
  return {{"plot", tree.plot},
          {"tree", tree.tree},
          {"species", tree.species},
          {"preset", tree.preset},
          {"file", grown.file},
          {"vertices", measured.vertices},
          {"triangles", measured.triangles},
          {"bytes", grown.bytes},
          {"h", measured.h_m},
          {"hcb", measured.hcb_m},
          {"dbh", measured.dbh_cm},
          {"cw", measured.radii.width_m()},
          {"radii",
           {{"e", measured.radii.east_m},
            {"w", measured.radii.west_m},
            {"s", measured.radii.south_m},
            {"n", measured.radii.north_m}}},
          {"notes", std::move(notes)}};
}

ordered_json json_of(const tree::LeftOut& left_out) {
  const ordered_json line = left_out.place.line ? ordered_json(*left_out.place.line) : nullptr;
  return {{"plot", left_out.place.plot},
          {"tree", left_out.place.tree},
          {"line", line},
          {"column", left_out.place.column},
          {"reason", left_out.reason}};
}

void report(const GrowCommand& command,
            const std::vector<GrownTree>& grown,
            const std::vector<tree::LeftOut>& left_out,
            double seconds) {
  std::size_t triangles = 0;
  std::size_t with_guesses = 0;
  ordered_json trees = ordered_json::array();
  for (const GrownTree& tree : grown) {
    triangles += tree.tree.measured.triangles;
    with_guesses += tree.tree.notes.empty() ? 0 : 1;
    if (command.common.json) trees.push_back(json_of(tree));
  }
  if (command.common.json) {
    ordered_json rows = ordered_json::array();
    for (const tree::LeftOut& row : left_out) rows.push_back(json_of(row));
    const ordered_json result{{"schema", "silvafit-grow/1"},
                              {"silvafit", version()},
                              {"use", command.use},
                              {"seed", command.common.seed},
                              {"trees", std::move(trees)},
                              {"left_out", std::move(rows)},
                              {"seconds", seconds}};
    fmt::print("{}\n", result.dump());
    return;
  }
  fmt::print("{} trees, {} triangles, {:.2f} s: {}\n",
             grown.size(),
             triangles,
             seconds,
             command.scene.empty() ? command.out : command.scene);
  if (with_guesses > 0) {
    say(command.common,
        fmt::format("{} trees have parts that were not measured; --json says which.",
                    with_guesses));
  }
}

void report_left_out(const GrowCommand& command, const std::vector<tree::LeftOut>& left_out) {
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < left_out.size() && i < kShown; ++i) {
    fmt::print(stderr, "{}\n", describe(left_out[i].place, left_out[i].reason + "; left out"));
  }
  if (left_out.size() > kShown) {
    fmt::print(stderr,
               "... and {} more rows are left out of {}\n",
               left_out.size() - kShown,
               command.file);
  }
}

tree::SceneTree grow_one(const tree::Morphology& morphology,
                         const tree::Preset* preset,
                         const tree::Preset& fallback,
                         std::uint64_t seed) {
  tree::SceneTree tree =
      tree::grow_tree(morphology, preset != nullptr ? *preset : fallback, {.seed = seed});
  if (preset == nullptr) {
    tree.notes.push_back({"preset", "no preset lists the species: " + fallback.name});
  }
  return tree;
}

/// Puts a tree into a file of its own; its mesh is not kept.
GrownTree write_alone(tree::SceneTree tree, const fs::path& path) {
  tree::Scene scene;
  scene.trees.push_back(std::move(tree));
  const std::string bytes = tree::glb_bytes(scene);
  write_file(path, bytes);
  GrownTree grown{std::move(scene.trees.front()), path.string(), bytes.size()};
  grown.tree.mesh = {};
  return grown;
}

/// Puts all trees into one file; their meshes are not kept.
void write_together(std::vector<GrownTree>& grown,
                    const tree::Position& origin,
                    const std::string& file) {
  tree::Scene scene{.origin = origin};
  scene.trees.reserve(grown.size());
  for (GrownTree& one : grown) {
    tree::Mesh mesh = std::move(one.tree.mesh);
    one.tree.mesh = {};
    scene.trees.push_back(one.tree);
    scene.trees.back().mesh = std::move(mesh);
  }
  tree::write_glb(std::move(scene), file);
}

void run(const GrowCommand& command) {
  if (command.scene.empty() == command.out.empty()) {
    throw UsageError("say where the trees go: --scene FILE.glb for all in one, or --out DIR");
  }
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = tree::PresetCatalogue::load(data_directory() / "models");
  const tree::MorphologyTable table = read_trees(command);
  report_left_out(command, table.left_out);
  const std::vector<tree::Morphology>& morphologies = table.morphologies;
  if (morphologies.empty()) {
    throw InputError("no tree can be grown from its rows", {.file = command.file});
  }
  const auto presets = presets_of(morphologies, catalogue, command);
  const std::vector<std::string> names = file_names(morphologies);

  std::vector<GrownTree> grown(morphologies.size());
  Progress progress(command.common);
  std::atomic<std::size_t> done = 0;
  parallel_for(morphologies.size(), command.common.threads, [&](std::size_t i) {
    tree::SceneTree tree =
        grow_one(morphologies[i], presets[i], catalogue.fallback(), command.common.seed);
    if (command.scene.empty()) {
      grown[i] = write_alone(std::move(tree), fs::path(command.out) / names[i]);
    } else {
      const std::size_t bytes = tree::glb_mesh_bytes(tree.mesh);
      grown[i] = {std::move(tree), command.scene, bytes};
    }
    progress.show("growing", ++done, morphologies.size());
  });
  if (!command.scene.empty()) {
    write_together(grown, tree::scene_origin(morphologies), command.scene);
  }
  progress.clear();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report(command, grown, table.left_out, seconds.count());
}

}  // namespace

void add_grow_command(CLI::App& program) {
  auto options = std::make_shared<GrowCommand>();
  CLI::App* command =
      program.add_subcommand("grow", "Grow measured or predicted trees as 3D models");
  command->add_option("morphology", options->file, "CSV of an inventory or of predictions")
      ->required()
      ->type_name("FILE.csv");
  command
      ->add_option(
          "--use", options->use, "Which h, hcb and cw: observed, ols, population, conditional")
      ->capture_default_str();
  command->add_option(
      "--preset", options->preset, "Species preset for all trees (default: by species)");
  command->add_option("--scene", options->scene, "One GLB file with all trees at their places")
      ->type_name("FILE.glb");
  command->add_option("--out", options->out, "Folder for one GLB file a tree, at the origin")
      ->type_name("DIR");
  command->add_option("--format", options->format, "File format")
      ->check(CLI::IsMember({"glb"}))
      ->capture_default_str();
  command->add_option("--builder", options->builder, "How trees are built")
      ->check(CLI::IsMember({"segment"}))
      ->capture_default_str();
  command->add_option("--plot", options->plots, "Plots to grow, separated by commas (default: all)")
      ->delimiter(',');
  command
      ->add_option("--columns",
                   options->columns,
                   "Other names or units of columns, as in h=H_m,dbh=DBH_mm/10")
      ->delimiter(',');
  add_common_options(*command, options->common);
  add_example(*command,
              "silvafit grow examples/fir-mixed/inventory.csv --plot 1 --scene plot1.glb");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
