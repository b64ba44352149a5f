// SPDX-License-Identifier: MIT
// Checks that the output files of a command differ from its input files and from each other.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

namespace silvafit::cli {

/// A file of the command line.
struct NamedFile {
  std::string option{};          ///< "--out", or the word in --help: "INVENTORY.csv"
  std::filesystem::path path{};  ///< empty: not given
};

/// Called before anything is computed, because an overwritten file is lost.
///
/// Different paths, symbolic links and hard links of one file are recognized. Devices and pipes,
/// such as /dev/stdout and /dev/null, store nothing and may be named several times.
/// \param read     files that the command reads; missing ones are reported by their readers
/// \param written  files that it writes
/// \throws UsageError with the two options that name the same file
void refuse_same_files(const std::vector<NamedFile>& read, const std::vector<NamedFile>& written);

/// The files of these names in the folder that an option names; none without a folder.
std::vector<NamedFile> files_in(const NamedFile& folder, std::initializer_list<const char*> names);

/// All files that one option names.
std::vector<NamedFile> all_of(const std::string& option, const std::vector<std::string>& paths);

}  // namespace silvafit::cli
