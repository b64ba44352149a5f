// SPDX-License-Identifier: MIT
// The names of the files that `silvafit grow` writes.
#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "grow_command.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;

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
  return safe;
}

std::string level_suffix(const GrowCommand& command, int level) {
  return command.levels.size() > 1 && level > 0 ? fmt::format("-lod{}", level) : std::string();
}

/// `path` with a suffix before its ending.
std::string with_suffix(const fs::path& path, const std::string& suffix) {
  fs::path named = path;
  named.replace_filename(path.stem().string() + suffix + path.extension().string());
  return named.string();
}

}  // namespace

std::vector<std::string> tree_names(const std::vector<tree::Morphology>& morphologies) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const tree::Morphology& morphology : morphologies) {
    const std::string plain = file_name(morphology.plot + "-" + morphology.tree);
    std::string name = plain;
    // Plot a, tree b-c and plot a-b, tree c share a name; a tilde is in no other.
    for (int copy = 2; !taken.insert(name).second; ++copy) name = plain + fmt::format("~{}", copy);
    names.push_back(std::move(name));
  }
  return names;
}

fs::path tree_path(const GrowCommand& command, const std::string& name, int level) {
  return fs::path(command.out) /
         (name + level_suffix(command, level) + "." + tree::file_ending(command.scene_format));
}

fs::path scene_path(const GrowCommand& command, int level) {
  const std::string suffix = level_suffix(command, level);
  return suffix.empty() ? command.scene : with_suffix(command.scene, suffix);
}

GrowCommand of_moment(const GrowCommand& command, const tree::Moment& moment) {
  GrowCommand one = command;
  const std::string name = file_name(moment.name);
  if (command.scene.empty()) {
    one.out = (fs::path(command.out) / name).string();
  } else {
    one.scene = with_suffix(command.scene, "-" + name);
  }
  return one;
}

}  // namespace silvafit::cli
