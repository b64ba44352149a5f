// SPDX-License-Identifier: MIT
// The files and folders of this process that are not finished, which an interrupt removes.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace silvafit {

/// Each file or folder is made and noted in one step under a lock, so that an interrupt never
/// comes between the two. Names are random and are opened only if nothing has them yet: processes
/// that share a folder, even with equal numbers, never share a file, and no link is followed.
class UnfinishedFiles {
 public:
  static UnfinishedFiles& of_process();

  /// An open file.
  struct Opened {
    int descriptor = -1;  ///< -1: none could be made, for the reason in errno
    std::filesystem::path path{};
  };

  /// Makes a file beside its target, named after it with six random letters and `.part`.
  /// \param mode  its permissions, less those that the process takes away (umask)
  Opened make_file(const std::filesystem::path& target, mode_t mode);
  /// Makes a file beside another one that has no name, so that it is gone when it is closed.
  /// \return its descriptor; -1: none could be made, for the reason in errno
  int make_nameless_file(const std::filesystem::path& beside);
  /// Makes a folder whose name ends in six random letters, for temporary files.
  /// \param pattern  path that ends in six letters X, which the random ones replace (mkdtemp)
  /// \return its path; empty if none could be made, with the reason in errno
  std::filesystem::path make_temporary_folder(std::string pattern);
  /// Makes a folder and those above it that are missing.
  /// \param made  those that were made are added, outer ones first
  std::error_code make_folders(const std::filesystem::path& folder,
                               std::vector<std::filesystem::path>& made);
  /// Does something that an interrupt must not divide, such as giving several files their names.
  void undivided(const std::function<void()>& action);
  /// A file or temporary folder has its final name, or is gone.
  void forget(const std::filesystem::path& path);
  /// Removes all that is not finished, and folders that were made and are empty. Other threads that
  /// begin a file from now on wait for the end of the process.
  void discard();

 private:
  std::mutex mutex_;
  std::set<std::filesystem::path> paths_;
  std::vector<std::filesystem::path> folders_;
};

/// Removes folders that are empty, the last first.
void remove_empty(const std::vector<std::filesystem::path>& folders);

}  // namespace silvafit
