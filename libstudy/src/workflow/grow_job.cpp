// SPDX-License-Identifier: MIT
// Checks and completes the settings of growing.
#include "workflow/grow_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "silvafit/base/error.hpp"

namespace silvafit::study {
namespace {

void check_moments(const GrowJob& job) {
  if (!job.by.empty() && job.share) {
    throw UsageError("`by` gives each tree its own models; omit `share`");
  }
  if (!job.animate) return;
  if (job.by.empty() || job.scene.empty()) {
    throw UsageError("`animate` needs `by`, the column with the times, and `scene`");
  }
  const bool is_gltf =
      job.scene_format == tree::SceneFormat::kGlb || job.scene_format == tree::SceneFormat::kGltf;
  if (!is_gltf) throw UsageError("`animate` needs the format glb or gltf");
  if (job.resolve_overlaps || job.levels.size() > 1) {
    throw UsageError(
        "`animate` allows only one level of detail and cannot be combined with `resolve_overlaps`");
  }
}

/// The files of `out`, and what parts of a table do not have.
void check_parts(const GrowJob& job) {
  if (job.is_by_plot && (job.out.empty() || !job.by.empty())) {
    throw UsageError(
        "`per=plot` needs `out`, the folder of the plots' files, and one time; omit "
        "`scene` and `by`");
  }
  if (!job.manifest.empty() && (job.share || !job.by.empty())) {
    throw UsageError("`manifest` cannot be combined with `share` and `by`; use `json`");
  }
  if (!job.stream) return;
  if (!job.scene.empty()) {
    throw UsageError(
        "a scene needs all trees; with `stream`, use `out=DIR` for one file per tree, and add "
        "`per=plot` for one file per plot, or cut the inventory with `silvafit tiles`",
        {.column = "`stream`"});
  }
  if (!job.by.empty()) {
    throw UsageError("`by` needs all rows; omit `stream` or `by`", {.column = "`stream`"});
  }
  if (job.resolve_overlaps && !job.is_by_plot) {
    throw UsageError(
        "neighbors may be in another part of the file; with `stream`, overlaps are resolved within "
        "plots only: add `per=plot`",
        {.column = "`stream`"});
  }
}

void check_sharing(const GrowJob& job) {
  if (job.share && (job.scene.empty() || job.resolve_overlaps)) {
    throw UsageError(
        "`share` needs `scene` and cannot be combined with `resolve_overlaps`, which gives each "
        "tree its own shape");
  }
  if (job.instancing && !job.share) {
    throw UsageError("`instancing` needs shared models; add `share=true`");
  }
}

void check_dead_wood(const GrowJob& job) {
  if (!job.dead_wood) return;
  if (job.share || job.resolve_overlaps || job.animate || job.is_unfitted) {
    throw UsageError(
        "`dead_wood` draws wood without crowns; omit `share`, `resolve_overlaps`, `animate` and "
        "`unfitted`");
  }
}

void check_unfitted(const GrowJob& job) {
  if (!job.is_unfitted) return;
  const bool is_free =
      job.builder == tree::BuilderKind::kLsystem || job.builder == tree::BuilderKind::kIfs;
  if (!is_free) throw UsageError("`unfitted` needs the `builder` lsystem or ifs");
  if (job.share || job.resolve_overlaps || job.animate) {
    throw UsageError(
        "`unfitted` draws trees without their crowns; omit `share`, `resolve_overlaps` and "
        "`animate`");
  }
}

/// \param job  with its format and textures
void check_levels(const GrowJob& job) {
  for (const int level : job.levels) {
    if (level < 0 || level > tree::kImpostorLevel) {
      throw UsageError(
          fmt::format("`lod` must be from 0 (finest) to {} (pictures of crowns), not {}",
                      tree::kImpostorLevel,
                      level));
    }
  }
  if (job.levels.back() < tree::kImpostorLevel) return;
  if (!job.textures) {
    throw UsageError(fmt::format(
        "`lod={}` shows crowns as pictures; omit `textures`, use the format glb, gltf or "
        "obj, or use `lod={}`",
        tree::kImpostorLevel,
        tree::kImpostorLevel - 1));
  }
  if (job.resolve_overlaps || job.is_unfitted) {
    throw UsageError(
        fmt::format("`lod={}` shows whole crowns, fitted to the measurements; omit "
                    "`resolve_overlaps` and `unfitted`, or use `lod={}`",
                    tree::kImpostorLevel,
                    tree::kImpostorLevel - 1));
  }
}

/// The ending of a file's name, without the dot.
std::string ending_of(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  return ending.empty() ? ending : ending.substr(1);
}

/// --out is a folder; a new one with the name of a model file was meant as a file.
void check_folder(const GrowJob& job) {
  if (find_word<tree::SceneFormat>(ending_of(job.out)) && !std::filesystem::is_directory(job.out)) {
    throw UsageError(
        fmt::format("`out` is a folder for one file per tree; for one file with all trees, use "
                    "`scene={}`",
                    job.out));
  }
}

/// The requested format, or that of the scene's file name ending.
tree::SceneFormat scene_format_of(const GrowJob& job) {
  const std::string ending = ending_of(job.scene);
  const auto of_ending = find_word<tree::SceneFormat>(ending);
  if (job.format && of_ending && *job.format != *of_ending) {
    throw UsageError(fmt::format("`scene` ends in .{} but `format` is {}; remove one of the two",
                                 ending,
                                 word_of(*job.format)));
  }
  if (job.format) return *job.format;
  return ending.empty() ? tree::SceneFormat::kGlb
                        : value_of<tree::SceneFormat>(ending, "scene format");
}

}  // namespace

GrowJob grow_job(const GrowSettings& settings,
                 const std::string& file,
                 const Callbacks& callbacks) {
  GrowJob job{settings, tree::SceneFormat::kGlb, file, callbacks};
  if (!job.grammar.empty() && job.builder != tree::BuilderKind::kLsystem) {
    throw UsageError("`grammar` needs `builder=lsystem`");
  }
  if (job.scene.empty() && job.out.empty()) {
    throw UsageError(
        "no output is given; use `scene=FILE` for one file, or `out=DIR` for one file per tree");
  }
  if (!job.scene.empty() && !job.out.empty()) {
    throw UsageError(
        "`scene` writes all trees to one file, `out` writes one file per tree; use one of the two");
  }
  check_folder(job);
  check_sharing(job);
  check_unfitted(job);
  check_dead_wood(job);
  std::sort(job.levels.begin(), job.levels.end());
  job.levels.erase(std::unique(job.levels.begin(), job.levels.end()), job.levels.end());
  job.scene_format = scene_format_of(job);
  if (job.scene_format == tree::SceneFormat::kPly) job.textures = false;
  check_levels(job);
  if (job.ascii && job.scene_format != tree::SceneFormat::kPly) {
    throw UsageError("`ascii` needs the format ply");
  }
  if (job.models_per_preset == 0)
    throw UsageError("the number of models per preset must be at least 1");
  check_moments(job);
  check_parts(job);
  return job;
}

tree::GrowOptions grow_options(const GrowJob& job, int level) {
  const bool is_far = level == tree::kImpostorLevel;
  return {.seed = job.seed,
          .mesh = tree::level_of_detail(std::min(level, tree::kLevelsOfDetail - 1),
                                        {.textured = job.textures, .season = job.season}),
          .is_unfitted = job.is_unfitted,
          .impostors = is_far ? &job.state->impostors : nullptr};
}

}  // namespace silvafit::study
