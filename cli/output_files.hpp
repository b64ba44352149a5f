// SPDX-License-Identifier: MIT
// Files that a command writes must not be those that it reads, nor each other.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

namespace silvafit::cli {

/// A file as the command line names it.
struct NamedFile {
  std::string option{};          ///< "--out", or as --help calls it: "INVENTORY.csv"
  std::filesystem::path path{};  ///< empty: not given
};

/// Called before anything is computed, because an overwritten file is lost.
///
/// Files are the same whatever path, symbolic link or hard link names them. Devices and pipes, such
/// as /dev/stdout and /dev/null, keep nothing and may be named as often as one likes.
/// \param read     files that the command reads; those that are not there are left to their readers
/// \param written  files that it writes
/// \throws UsageError that says which two options name the same file
void refuse_same_files(const std::vector<NamedFile>& read, const std::vector<NamedFile>& written);

/// The files of these names in the folder that an option names; none without a folder.
std::vector<NamedFile> files_in(const NamedFile& folder, std::initializer_list<const char*> names);

/// All files that one option names.
std::vector<NamedFile> all_of(const std::string& option, const std::vector<std::string>& paths);

}  // namespace silvafit::cli
