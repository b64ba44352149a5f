// SPDX-License-Identifier: MIT
#include "silvafit/base/paths.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "silvafit/base/built_in_files.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_read(const fs::path& path, const std::error_code& error) {
  throw InputError(fmt::format("cannot read ({})", error.message()), {.file = path.string()});
}

/// What a path is among the files of the program.
PathKind built_in_kind_of(const fs::path& path) {
  const auto next = built_in_files().lower_bound(path);
  if (path.empty() || next == built_in_files().end()) return PathKind::kNothing;
  const auto [rest, below] =
      std::mismatch(path.begin(), path.end(), next->first.begin(), next->first.end());
  if (rest != path.end()) return PathKind::kNothing;
  return below == next->first.end() ? PathKind::kFile : PathKind::kFolder;
}

}  // namespace

PathKind kind_of(const fs::path& path) {
  const PathKind built_in = built_in_kind_of(path);
  if (built_in != PathKind::kNothing) return built_in;
  std::error_code error;
  switch (fs::status(path, error).type()) {
    case fs::file_type::not_found:
      return PathKind::kNothing;
    case fs::file_type::regular:
      return PathKind::kFile;
    case fs::file_type::directory:
      return PathKind::kFolder;
    case fs::file_type::none:
      cannot_read(path, error);
    default:
      return PathKind::kStream;
  }
}

bool is_there(const fs::path& path) { return kind_of(path) != PathKind::kNothing; }

fs::path followed(const fs::path& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  if (error) return path;
  const fs::path whole = fs::weakly_canonical(absolute, error);
  return error ? absolute : whole;
}

std::vector<fs::path> files_in_folder(const fs::path& folder, std::string_view ending) {
  std::error_code error;
  std::vector<fs::path> files;
  if (built_in_kind_of(folder) == PathKind::kFolder) {
    for (const auto& [file, bytes] : built_in_files()) {
      if (file.parent_path() == folder && file.extension() == ending) files.push_back(file);
    }
    return files;
  }
  fs::directory_iterator entry(folder, error);
  while (!error && entry != fs::directory_iterator()) {
    if (entry->path().extension() == ending) files.push_back(entry->path());
    entry.increment(error);
  }
  if (error) cannot_read(folder, error);
  std::ranges::sort(files);
  return files;
}

}  // namespace silvafit
