// SPDX-License-Identifier: MIT
// The options of `silvafit grow`, and checks of their combinations.
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

/// Selection of trees and builders.
void add_table_options(CLI::App& command, GrowCommand& options) {
  command.add_option("morphology", options.file, "CSV of an inventory or of predictions")
      ->required()
      ->type_name("FILE.csv");
  command
      .add_option(
          "--use", options.use, "Source of h, hcb and cw: observed, ols, population, conditional")
      ->capture_default_str();
  command.add_option(
      "--preset", options.preset, "Species preset for all trees (default: by species)");
}

/// Output files and levels of detail.
void add_scene_options(CLI::App& command, GrowCommand& options) {
  command.add_option("--scene", options.scene, "Write one file with all trees at their positions")
      ->type_name("FILE");
  CLI::Option* out =
      command
          .add_option(
              "--out", options.out, "Write one file per tree, at the origin, to this folder")
          ->type_name("DIR");
  command
      .add_option(
          "--format",
          options.format,
          "File format: glb, gltf, obj or ply (default: from the ending of --scene, else glb)")
      ->check(CLI::IsMember({"glb", "gltf", "obj", "ply"}));
  command.add_flag("--resolve-overlaps",
                   options.resolve_overlaps,
                   "Remove and turn branches where the crowns of neighbors overlap");
  command
      .add_option("--lod",
                  options.levels,
                  "Level of detail, 0 (finest) to 3; several levels, such as 0,2, are written to "
                  "separate files")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option(
          "--ground", options.ground, "Ground of a scene: through the stem bases, flat, or none")
      ->check(CLI::IsMember({"stems", "flat", "none"}))
      ->excludes(out)
      ->capture_default_str();
}

/// Content of the files.
void add_file_options(CLI::App& command, GrowCommand& options) {
  CLI::Option* share = command.add_flag(
      "--share",
      options.share,
      "Trees of similar shape share a model, scaled to their height and crown width");
  command
      .add_option("--models", options.models_per_preset, "Number of models per preset with --share")
      ->needs(share)
      ->capture_default_str();
  command.add_flag("--instancing",
                   options.instancing,
                   "GLB, glTF: use EXT_mesh_gpu_instancing for trees that share a model");
  command.add_flag("--quantize", options.quantize, "GLB, glTF: use KHR_mesh_quantization");
  command.add_flag(
      "--compress", options.compress, "GLB, glTF: use EXT_meshopt_compression and quantization");
  command.add_flag("--ascii", options.ascii, "Write PLY as text");
  command.add_flag(
      "--textures", options.textures, "GLB, glTF, OBJ: add textures of bark and leaves");
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
          "Builder of the trees (for its presets: silvafit models --builders)")
      ->check(CLI::IsMember(builders))
      ->default_str(tree::builder_name(options.builder));
  command
      .add_option("--grammar",
                  options.grammar,
                  "L-system grammar for all trees, with --builder lsystem; the preset gives crown, "
                  "taper, bark and leaves")
      ->type_name("FILE.lsys");
}

/// Rows and columns of the table.
void add_row_options(CLI::App& command, GrowCommand& options) {
  add_names_option(
      command, "--plot", options.plots, "Plots to grow, separated by commas (default: all)");
  add_columns_option(command, options.columns);
  add_sheet_options(command, options.sheet);
  add_dead_option(command, options.sheet);
}

/// Repeated measurements.
void add_time_options(CLI::App& command, GrowCommand& options) {
  command.add_option("--by",
                     options.by,
                     "Column with the time of each row, such as year; writes one scene per time: "
                     "FILE-2021.glb, FILE-2022.glb, ...");
  CLI::Option* animate = command.add_flag(
      "--animate",
      options.animate,
      "GLB, glTF: write one animated scene in which the trees grow over the times of --by");
  command
      .add_option("--seconds",
                  options.seconds_per_unit,
                  "Duration of the animation per unit of --by, or per step if --by is text")
      ->check(CLI::PositiveNumber)
      ->needs(animate)
      ->capture_default_str();
}

void check_moments(const GrowCommand& command) {
  if (!command.by.empty() && command.share) {
    throw UsageError("--by gives each tree its own models; omit --share");
  }
  if (!command.animate) return;
  if (command.by.empty() || command.scene.empty()) {
    throw UsageError("--animate needs --by, the column with the times, and --scene");
  }
  const bool is_gltf = command.scene_format == tree::SceneFormat::kGlb ||
                       command.scene_format == tree::SceneFormat::kGltf;
  if (!is_gltf) throw UsageError("--animate needs the format glb or gltf");
  if (command.resolve_overlaps || command.levels.size() > 1) {
    throw UsageError(
        "--animate allows only one level of detail and cannot be combined with --resolve-overlaps");
  }
}

void check_sharing(const GrowCommand& command) {
  if (command.share && (command.scene.empty() || command.resolve_overlaps)) {
    throw UsageError(
        "--share needs --scene and cannot be combined with --resolve-overlaps, which gives each "
        "tree its own shape");
  }
  if (command.instancing && !command.share) {
    throw UsageError("--instancing needs shared models; add --share");
  }
}

/// The requested format, or that of the scene's file name ending.
tree::SceneFormat scene_format_of(const GrowCommand& command) {
  std::string format = command.format;
  const std::string ending = std::filesystem::path(command.scene).extension().string();
  const std::string of_ending = ending.empty() ? "" : ending.substr(1);
  if (format.empty()) format = of_ending.empty() ? "glb" : of_ending;
  constexpr std::array<std::string_view, 4> kEndings{"glb", "gltf", "obj", "ply"};
  if (format != of_ending && std::ranges::find(kEndings, of_ending) != kEndings.end()) {
    throw UsageError(fmt::format(
        "--scene ends in .{} but --format is {}; remove one of the two", of_ending, format));
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
    throw UsageError("--grammar needs --builder lsystem");
  }
  if (command.scene.empty() && command.out.empty()) {
    throw UsageError(
        "no output is given; use --scene FILE for one file, or --out DIR for one file per tree");
  }
  if (!command.scene.empty() && !command.out.empty()) {
    throw UsageError(
        "--scene writes all trees to one file, --out writes one file per tree; use one of the two");
  }
  check_sharing(command);
  std::sort(command.levels.begin(), command.levels.end());
  command.levels.erase(std::unique(command.levels.begin(), command.levels.end()),
                       command.levels.end());
  for (const int level : command.levels) static_cast<void>(tree::level_of_detail(level));
  command.scene_format = scene_format_of(command);
  if (command.textures && command.scene_format == tree::SceneFormat::kPly) {
    throw UsageError("PLY files have no textures; --textures needs glb, gltf or obj");
  }
  if (command.ascii && command.scene_format != tree::SceneFormat::kPly) {
    throw UsageError("--ascii needs the format ply");
  }
  if (command.models_per_preset == 0) throw UsageError("--models must be at least 1");
  check_moments(command);
}

}  // namespace silvafit::cli
