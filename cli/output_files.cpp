// SPDX-License-Identifier: MIT
#include "output_files.hpp"

#include <fmt/format.h>

#include <system_error>

#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"

namespace silvafit::cli {
namespace {

namespace fs = std::filesystem;

/// A device such as /dev/stdout may be any file, because the shell may redirect it.
bool is_stream(const fs::path& path) {
  if (path.lexically_normal().string().starts_with("/dev/")) return true;
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// Whether both are the same file, or would be after it is created.
bool are_same(const fs::path& one, const fs::path& other) {
  if (one.empty() || other.empty() || is_stream(one) || is_stream(other)) return false;
  std::error_code error;
  if (fs::equivalent(one, other, error) && !error) return true;
  return followed(one) == followed(other);
}

}  // namespace

void refuse_same_files(const std::vector<NamedFile>& read, const std::vector<NamedFile>& written) {
  for (auto one = written.begin(); one != written.end(); ++one) {
    for (const NamedFile& input : read) {
      std::error_code ignored;
      if (!fs::exists(input.path, ignored) || !are_same(one->path, input.path)) continue;
      throw UsageError(fmt::format("{} and {} are the same file, and the input would be "
                                   "overwritten; choose another name",
                                   one->option,
                                   input.option),
                       {.file = one->path.string()});
    }
    for (auto other = written.begin(); other != one; ++other) {
      if (!are_same(one->path, other->path)) continue;
      throw UsageError(
          fmt::format(
              "{} and {} are the same file, and one would overwrite the other; choose another name",
              other->option,
              one->option),
          {.file = one->path.string()});
    }
  }
}

std::vector<NamedFile> files_in(const NamedFile& folder, std::initializer_list<const char*> names) {
  std::vector<NamedFile> files;
  if (folder.path.empty()) return files;
  for (const char* name : names) files.push_back({folder.option, folder.path / name});
  return files;
}

std::vector<NamedFile> all_of(const std::string& option, const std::vector<std::string>& paths) {
  std::vector<NamedFile> files;
  files.reserve(paths.size());
  for (const std::string& path : paths) files.push_back({option, path});
  return files;
}

}  // namespace silvafit::cli
