// SPDX-License-Identifier: MIT
// Checks and completes the settings of growing; the names of the files that it writes.
#include "workflow/grow_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <string_view>

#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/words.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "silvafit/study/idle_settings.hpp"

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
  if (job.reading.dead == stand::DeadTrees::kInclude) {
    throw UsageError("has no effect with `dead=include`, by which dead trees are living ones",
                     {.column = "`dead_wood`"});
  }
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

/// The ending of a file's name, in lower case and without the dot.
std::string ending_of(const std::filesystem::path& path) {
  const std::string ending = in_lower_case(path.extension().string());
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
  refuse_idle_settings(settings);
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

namespace {

namespace fs = std::filesystem;

/// Names with their endings stay below the limit of file systems (255 bytes).
constexpr std::size_t kLongestName = 160;

/// Part of a file name that all file systems accept; bytes other than letters, digits, `.`, `_` and
/// `-` become %XX, so that different names stay different.
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
  return safe;
}

/// Whether a name has the suffix of a coarser level.
bool looks_like_level(const std::string& name) {
  const std::size_t end = name.find_last_not_of("0123456789");
  return end != std::string::npos && end + 1 < name.size() &&
         name.substr(0, end + 1).ends_with("-lod");
}

/// A name that is not too long and differs from that of a coarser level of another tree. No other
/// name contains a tilde.
std::string distinct_from_levels(const std::string& name) {
  if (name.size() > kLongestName) return name.substr(0, kLongestName) + "~";
  return looks_like_level(name) ? name + "~" : name;
}

/// The name, or a numbered one if the folder has it (ignoring case, as some file systems do).
std::string untaken(const GrowJob& job, const std::string& name) {
  const auto folded = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  std::string candidate = name;
  for (int copy = 2; !job.state->names.take(job.out + '/' + folded(candidate)); ++copy) {
    candidate = fmt::format("{}~{}", name, copy);
  }
  return candidate;
}

std::string level_suffix(const GrowSettings& settings, int level) {
  return settings.levels.size() > 1 && level > 0 ? fmt::format("-lod{}", level) : std::string();
}

/// `path` with a suffix before its ending.
std::string with_suffix(const fs::path& path, const std::string& suffix) {
  fs::path named = path;
  named.replace_filename(path.stem().string() + suffix + path.extension().string());
  return named.string();
}

}  // namespace

bool TakenNames::take(std::string_view name) {
  Fingerprint hash;
  hash.add(name);
  if (std::ranges::binary_search(sorted_, hash.value())) return false;
  if (!recent_.insert(hash.value()).second) return false;
  constexpr std::size_t kFewest = 4096;
  if (recent_.size() < std::max(kFewest, sorted_.size() / 16)) return true;
  const auto before = static_cast<std::ptrdiff_t>(sorted_.size());
  sorted_.insert(sorted_.end(), recent_.begin(), recent_.end());
  recent_.clear();
  std::sort(sorted_.begin() + before, sorted_.end());
  std::inplace_merge(sorted_.begin(), sorted_.begin() + before, sorted_.end());
  return true;
}

std::vector<std::string> tree_names(const GrowJob& job,
                                    const std::vector<tree::Morphology>& morphologies) {
  std::vector<std::string> names;
  names.reserve(morphologies.size());
  for (const tree::Morphology& morphology : morphologies) {
    // Plot a, tree b-c and plot a-b, tree c would have the same name.
    names.push_back(
        untaken(job, distinct_from_levels(file_name(morphology.plot + "-" + morphology.tree))));
  }
  return names;
}

fs::path tree_path(const GrowJob& job, const std::string& name, int level) {
  return fs::path(job.out) / (name + level_suffix(job, level) + "." + word_of(job.scene_format));
}

std::string folder_text(const GrowJob& job, int level) {
  const std::string suffix = level_suffix(job, level);
  if (suffix.empty()) return job.out;
  return fmt::format("{} (*{}.{})", job.out, suffix, word_of(job.scene_format));
}

fs::path scene_path(const GrowSettings& settings, int level) {
  const std::string suffix = level_suffix(settings, level);
  return suffix.empty() ? settings.scene : with_suffix(settings.scene, suffix);
}

GrowJob of_plot(const GrowJob& job, const std::string& plot) {
  GrowJob one = job;
  const std::string name = untaken(job, distinct_from_levels(file_name(plot)));
  one.scene = (fs::path(job.out) / (name + "." + word_of(job.scene_format))).string();
  one.out.clear();
  return one;
}

GrowJob of_moment(const GrowJob& job, const tree::Moment& moment) {
  GrowJob one = job;
  const std::string plain = file_name(moment.name);
  if (plain.size() > kLongestName) {
    throw InputError(fmt::format(
        "`by={}`: a value of {} characters is too long for a file name; shorten it: {}...",
        job.by,
        moment.name.size(),
        moment.name.substr(0, 40)));
  }
  const std::string name = distinct_from_levels(plain);
  if (job.scene.empty()) {
    one.out = (fs::path(job.out) / name).string();
  } else {
    one.scene = with_suffix(job.scene, "-" + name);
  }
  return one;
}

}  // namespace silvafit::study
