// SPDX-License-Identifier: MIT
// The names of the files that `silvafit grow` writes.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "silvafit/base/error.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "workflow/grow_job.hpp"

namespace silvafit::study {
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
