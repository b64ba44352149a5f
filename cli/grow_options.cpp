// SPDX-License-Identifier: MIT
// The options of `silvafit grow`.
#include <string>

#include "grow_command.hpp"
#include "inventory_options.hpp"
#include "name_list.hpp"

namespace silvafit::cli {
namespace {

/// Selection of trees and builders.
void add_table_options(CLI::App& command, std::string& file, study::GrowSettings& options) {
  command
      .add_option(
          "morphology", file, "Inventory or predictions: a CSV file, workbook, layer or database")
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
void add_scene_options(CLI::App& command, study::GrowSettings& options) {
  command.add_option("--scene", options.scene, "Write one file with all trees at their positions")
      ->type_name("FILE");
  CLI::Option* out =
      command
          .add_option(
              "--out", options.out, "Write one file per tree, at the origin, to this folder")
          ->type_name("DIR");
  command
      .add_option("--per",
                  options.per,
                  "Files of --out: one per tree, or one per plot with its trees at their positions")
      ->check(CLI::IsMember({"tree", "plot"}))
      ->needs(out)
      ->capture_default_str();
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
                  "Level of detail, 0 (finest) to 3, or 4 for pictures of crowns on crossed cards; "
                  "several levels, such as 0,2, are written to separate files")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option(
          "--ground", options.ground, "Ground of a scene: through the stem bases, flat, or none")
      ->check(CLI::IsMember({"stems", "flat", "none"}))
      ->capture_default_str();
}

/// Content of the files.
void add_file_options(CLI::App& command, study::GrowSettings& options) {
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
  command.add_flag_callback(
      "--plain",
      [&options] { options.textures = false; },
      "Leaves as polygons in plain colors, instead of pictures of bark and shoots");
}

void add_builder_options(CLI::App& command, study::GrowSettings& options) {
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
  command.add_flag("--unfitted",
                   options.is_unfitted,
                   "Draw grammars and function systems as they are, scaled to the height h only "
                   "(--builder lsystem or ifs); no other measurement is needed");
}

/// Rows and columns of the table.
void add_row_options(CLI::App& command, study::GrowSettings& options) {
  add_names_option(
      command, "--plot", options.plots, "Plots to grow, separated by commas (default: all)");
  add_reading_options(command,
                      options.reading,
                      {"columns",
                       "missing",
                       "fill_down",
                       "case_sensitive",
                       "dead",
                       "alive_codes",
                       "dead_codes",
                       "cut_codes"});
}

/// Repeated measurements.
void add_time_options(CLI::App& command, study::GrowSettings& options) {
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

}  // namespace

void add_grow_options(CLI::App& command, std::string& file, study::GrowSettings& options) {
  add_table_options(command, file, options);
  add_scene_options(command, options);
  add_file_options(command, options);
  add_builder_options(command, options);
  add_row_options(command, options);
  add_time_options(command, options);
}

}  // namespace silvafit::cli
