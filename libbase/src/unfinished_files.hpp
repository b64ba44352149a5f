// SPDX-License-Identifier: MIT
// The files and folders of this process that are not finished, which an interrupt removes.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace silvafit {

/// Each file or folder is created and recorded under one lock, so that an interrupt cannot come
/// between the two. Names are random, and a file is opened only if its name is new: processes that
/// share a folder, even with equal process numbers, never share a file, and no link is followed.
class UnfinishedFiles {
 public:
  static UnfinishedFiles& of_process();

  /// An open file.
  struct Opened {
    int descriptor = -1;  ///< -1 on failure, with the reason in errno
    std::filesystem::path path{};
  };

  /// Makes a file beside its target, named after it with six random letters and `.part`.
  /// \param permissions  before the umask of the process is applied
  Opened make_file(const std::filesystem::path& target, std::filesystem::perms permissions);
  /// Makes a file beside another one that has no name, so that it is gone when it is closed.
  /// \return null on failure, with the reason in errno
  std::FILE* make_nameless_file(const std::filesystem::path& beside);
  /// Makes a folder for temporary files.
  /// \param beginning  of its path, which a dot and six random letters follow
  /// \return its path; empty on failure, with the reason in errno
  std::filesystem::path make_temporary_folder(const std::filesystem::path& beginning);
  /// Creates a folder and the missing ones above it.
  /// \param made  the created folders are added, outer ones first
  std::error_code make_folders(const std::filesystem::path& folder,
                               std::vector<std::filesystem::path>& made);
  /// Runs an action that an interrupt must not split, such as renaming several files.
  void undivided(const std::function<void()>& action);
  /// Stops tracking a file or temporary folder that has its final name or no longer exists.
  void forget(const std::filesystem::path& path);
  /// Removes all unfinished files, and created folders that are empty. Other threads that begin a
  /// file after this wait until the process ends.
  void discard();

 private:
  std::mutex mutex_;
  std::set<std::filesystem::path> paths_;
  std::vector<std::filesystem::path> folders_;
};

/// Removes empty folders, the last first.
void remove_empty(const std::vector<std::filesystem::path>& folders);

}  // namespace silvafit
