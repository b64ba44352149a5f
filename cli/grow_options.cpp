// SPDX-License-Identifier: MIT
// The options of `silvafit grow`, and which of them go together.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "grow_command.hpp"
#include "name_list.hpp"
#include "silvafit/base/error.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

/// What is grown.
void add_table_options(CLI::App& command, GrowCommand& options) {
  command.add_option("morphology", options.file, "CSV of an inventory or of predictions")
      ->required()
      ->type_name("FILE.csv");
  command
      .add_option(
          "--use", options.use, "Which h, hcb and cw: observed, ols, population, conditional")
      ->capture_default_str();
  command.add_option(
      "--preset", options.preset, "Species preset for all trees (default: by species)");
}

/// Where it goes, and how fine it is.
void add_scene_options(CLI::App& command, GrowCommand& options) {
  command.add_option("--scene", options.scene, "One file with all trees at their places")
      ->type_name("FILE");
  CLI::Option* out =
      command.add_option("--out", options.out, "Folder for one file a tree, at the origin")
          ->type_name("DIR");
  command
      .add_option("--format",
                  options.format,
                  "glb, gltf, obj or ply (default: by the ending of --scene, else glb)")
      ->check(CLI::IsMember({"glb", "gltf", "obj", "ply"}));
  command.add_flag("--resolve-overlaps",
                   options.resolve_overlaps,
                   "Remove and turn branches where neighbors' crowns overlap");
  command
      .add_option("--lod",
                  options.levels,
                  "Level of detail, 0 (finest) to 3; several, as in 0,2, go to files of their own")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option(
          "--ground", options.ground, "Ground of a scene: through the stems' feet, flat, or none")
      ->check(CLI::IsMember({"stems", "flat", "none"}))
      ->excludes(out)
      ->capture_default_str();
}

/// What the files hold.
void add_file_options(CLI::App& command, GrowCommand& options) {
  CLI::Option* share = command.add_flag(
      "--share", options.share, "Trees of like shape share a model, stretched to height and width");
  command.add_option("--models", options.models_per_preset, "Models a preset with --share")
      ->needs(share)
      ->capture_default_str();
  command.add_flag("--instancing",
                   options.instancing,
                   "GLB, glTF: EXT_mesh_gpu_instancing for trees that share a model");
  command.add_flag("--quantize", options.quantize, "GLB, glTF: KHR_mesh_quantization");
  command.add_flag(
      "--compress", options.compress, "GLB, glTF: EXT_meshopt_compression and quantization");
  command.add_flag("--ascii", options.ascii, "PLY as text");
  command.add_flag(
      "--textures", options.textures, "GLB, glTF, OBJ: pictures of bark and leaves in the file");
}

void add_builder_options(CLI::App& command, GrowCommand& options) {
  std::vector<std::string> builders;
  for (const tree::BuilderKind kind : tree::builder_kinds()) {
    builders.emplace_back(tree::builder_name(kind));
  }
  command
      .add_option_function<std::string>(
          "--builder",
          [&options](const std::string& name) { options.builder = tree::builder_from_text(name); },
          "How trees are built (their presets: silvafit models --builders)")
      ->check(CLI::IsMember(builders))
      ->default_str(tree::builder_name(options.builder));
  command
      .add_option("--grammar",
                  options.grammar,
                  "L-system of your own for all trees, with --builder lsystem; the preset gives "
                  "crown, taper, bark and leaves")
      ->type_name("FILE.lsys");
}

/// Which rows of the table, and what its columns are called.
void add_row_options(CLI::App& command, GrowCommand& options) {
  add_names_option(
      command, "--plot", options.plots, "Plots to grow, separated by commas (default: all)");
  add_columns_option(command, options.columns);
}

/// Trees that are measured again and again.
void add_time_options(CLI::App& command, GrowCommand& options) {
  command.add_option(
      "--by",
      options.by,
      "Column with the time of each row, such as year: a scene a time, FILE-2021.glb, "
      "FILE-2022.glb, ...");
  CLI::Option* animate =
      command.add_flag("--animate",
                       options.animate,
                       "GLB, glTF: one scene in which the trees of --by grow over time");
  command
      .add_option("--seconds",
                  options.seconds_per_unit,
                  "Of the animation a unit of --by, or a step where it holds text")
      ->check(CLI::PositiveNumber)
      ->needs(animate)
      ->capture_default_str();
}

void check_moments(const GrowCommand& command) {
  if (!command.by.empty() && command.share) {
    throw UsageError("--by gives each tree models of its own: leave out --share");
  }
  if (!command.animate) return;
  if (command.by.empty() || command.scene.empty()) {
    throw UsageError("--animate needs --by, the column with the times, and --scene");
  }
  const bool is_gltf = command.scene_format == tree::SceneFormat::kGlb ||
                       command.scene_format == tree::SceneFormat::kGltf;
  if (!is_gltf) throw UsageError("only glb and gltf hold animations");
  if (command.resolve_overlaps || command.levels.size() > 1) {
    throw UsageError("--animate is for one level of detail, and not with --resolve-overlaps");
  }
}

void check_sharing(const GrowCommand& command) {
  if (command.share && (command.scene.empty() || command.resolve_overlaps)) {
    throw UsageError(
        "--share is for a --scene, and not with --resolve-overlaps, which gives each tree a shape "
        "of its own");
  }
  if (command.instancing && !command.share) {
    throw UsageError("--instancing needs models that trees share: add --share");
  }
}

/// The format that is asked for, or the one that the scene's name ends with.
tree::SceneFormat scene_format_of(const GrowCommand& command) {
  std::string format = command.format;
  const std::string ending = std::filesystem::path(command.scene).extension().string();
  const std::string of_ending = ending.empty() ? "" : ending.substr(1);
  if (format.empty()) format = of_ending.empty() ? "glb" : of_ending;
  constexpr std::array<std::string_view, 4> kEndings{"glb", "gltf", "obj", "ply"};
  if (format != of_ending && std::ranges::find(kEndings, of_ending) != kEndings.end()) {
    throw UsageError(fmt::format(
        "--scene ends in .{} and --format says {}: leave one of them out", of_ending, format));
  }
  return tree::scene_format_from_text(format);
}

}  // namespace

void add_grow_options(CLI::App& command, GrowCommand& options) {
  add_table_options(command, options);
  add_scene_options(command, options);
  add_file_options(command, options);
  add_builder_options(command, options);
  add_row_options(command, options);
  add_time_options(command, options);
}

void check_and_complete(GrowCommand& command) {
  if (!command.grammar.empty() && command.builder != tree::BuilderKind::kLsystem) {
    throw UsageError("--grammar is for --builder lsystem");
  }
  if (command.scene.empty() && command.out.empty()) {
    throw UsageError("say where the trees go: --scene FILE for all in one, or --out DIR");
  }
  if (!command.scene.empty() && !command.out.empty()) {
    throw UsageError(
        "--scene puts all trees into one file and --out each into its own: leave one of them out");
  }
  check_sharing(command);
  std::sort(command.levels.begin(), command.levels.end());
  command.levels.erase(std::unique(command.levels.begin(), command.levels.end()),
                       command.levels.end());
  for (const int level : command.levels) static_cast<void>(tree::level_of_detail(level));
  command.scene_format = scene_format_of(command);
  if (command.textures && command.scene_format == tree::SceneFormat::kPly) {
    throw UsageError("PLY files hold no pictures: --textures is for glb, gltf and obj");
  }
  if (command.ascii && command.scene_format != tree::SceneFormat::kPly) {
    throw UsageError("--ascii is for PLY files");
  }
  if (command.models_per_preset == 0) throw UsageError("--models must be at least 1");
  check_moments(command);
}

}  // namespace silvafit::cli
