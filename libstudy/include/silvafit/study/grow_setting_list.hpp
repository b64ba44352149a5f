// SPDX-License-Identifier: MIT
// The settings of grown trees and scenes, each described once.
#pragma once

#include "silvafit/study/grow.hpp"
#include "silvafit/study/setting_list.hpp"

namespace silvafit::study {

/// The settings of a table's columns are those of GrowSettings::reading.
template <Same<GrowSettings> S, typename Visit>
void each_setting(S& settings, Visit&& visit) {
  using data::Setting;
  using data::SettingForm;
  visit(Setting("use",
                settings.use,
                "Source of h, hcb and cw: observed, ols, population, conditional (columns of a "
                "study), or pred (columns of predict)"));
  visit(Setting("preset", settings.preset, "Species preset for all trees (default: by species)"));
  visit(Setting("scene", settings.scene, "Write one file with all trees at their positions")
            .type("FILE"));
  visit(Setting("out", settings.out, "Write one file per tree, at the origin, to this folder")
            .type("DIR"));
  visit(Setting("per",
                settings.is_by_plot,
                "Files of the folder: one per tree, or one per plot with its trees at their "
                "positions")
            .one_of({"tree", "plot"}));
  visit(Setting("format",
                settings.format,
                "File format: glb, gltf, obj or ply (default: from the ending of the scene, else "
                "glb)"));
  visit(Setting("resolve_overlaps",
                settings.resolve_overlaps,
                "Remove and turn branches where the crowns of neighbors overlap"));
  visit(Setting("dead_wood",
                settings.dead_wood,
                "Draw dead trees as snags (a column decay gives their class, 1 to 5), cut ones as "
                "stumps and fallen ones as logs"));
  visit(Setting("lod",
                settings.levels,
                "Level of detail, 0 (finest) to 3, or 4 for pictures of crowns on crossed cards; "
                "several levels, such as 0,2, are written to separate files"));
  visit(
      Setting("ground", settings.ground, "Ground of a scene: through the stem bases, flat, or none")
          .needs(settings.out.empty() || settings.is_by_plot, "`scene` or `per=plot`"));
  visit(Setting("share",
                settings.share,
                "Trees of similar shape share a model, scaled to their height and crown width"));
  visit(Setting("models",
                settings.models_per_preset,
                "Number of models per preset of trees that share them")
            .needs(settings.share, "`share`"));
  visit(Setting("instancing",
                settings.instancing,
                "GLB, glTF: use EXT_mesh_gpu_instancing for trees that share a model"));
  visit(Setting("quantize", settings.quantize, "GLB, glTF: use KHR_mesh_quantization"));
  visit(Setting(
      "compress", settings.compress, "GLB, glTF: use EXT_meshopt_compression and quantization"));
  visit(Setting("ascii", settings.ascii, "Write PLY as text"));
  visit(Setting("textures",
                settings.textures,
                "Pictures of bark and shoots; plain: leaves as polygons in plain colors")
            .option("plain"));
  visit(Setting("season", settings.season, "Colors of leaves; deciduous trees are bare in winter"));
  visit(Setting("builder", settings.builder, "Builder of the trees; each has its own presets"));
  visit(Setting("grammar",
                settings.grammar,
                "L-system grammar for all trees, with the builder lsystem; the preset gives crown, "
                "taper, bark and leaves")
            .type("FILE.lsys"));
  visit(Setting("unfitted",
                settings.is_unfitted,
                "Draw grammars and function systems as they are, scaled to the height h only "
                "(builders lsystem and ifs); no other measurement is needed"));
  visit(Setting("plots", settings.plots, "Plots to grow, separated by commas (default: all)")
            .as(SettingForm::kNames, "PLOT,...")
            .option("plot"));
  visit(Setting("by",
                settings.by,
                "Column with the time of each row, such as year; writes one scene per time, such "
                "as FILE-2021.glb")
            .type("COLUMN"));
  visit(Setting("animate",
                settings.animate,
                "GLB, glTF: write one animated scene in which the trees grow over the times"));
  visit(Setting("seconds",
                settings.seconds_per_unit,
                "Duration of the animation per unit of the time, or per step if it is text")
            .needs(settings.animate, "`animate`"));
  visit(Setting("manifest",
                settings.manifest,
                "Write plot, tree, species, preset, level, file, triangles and bytes of each tree "
                "to this CSV file")
            .type("FILE.csv"));
}

}  // namespace silvafit::study
