// SPDX-License-Identifier: MIT
// Files that are written whole or not at all.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit {

/// Writes a temporary file beside the target and renames it to the target at commit(). Without
/// commit() the temporary file and the folders created for it are removed, and the target is
/// unchanged.
///
/// The temporary file has a random name that other processes cannot guess. If the target is a
/// symbolic link, the file that it points to is replaced; a replaced file keeps its permissions.
/// Devices and pipes, such as /dev/stdout, are written directly.
///
/// \throws IoError if the folder cannot be written to, or the disk is full
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream();
  /// Writes all bytes to the disk, closes the file and renames it to the target.
  void commit();

 private:
  friend void commit_together(const std::vector<AtomicFile*>& files);
  struct State;
  std::unique_ptr<State> state_;
};

/// Commits files that belong together: all are written completely before the first is renamed, in
/// this order. After discard_unfinished_files() all or none are replaced; if the process is killed,
/// only the first ones may be.
/// \throws IoError as AtomicFile::commit()
void commit_together(const std::vector<AtomicFile*>& files);

/// Writes the bytes to a file, completely or not at all, and creates its parent folders.
/// \throws IoError if that is not possible
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Checks that files can be written into a folder, or that it could be created.
/// \throws IoError if not
void require_writable_folder(const std::filesystem::path& folder);

/// A folder for results. Folders that it created and that are still empty are removed at the end of
/// its scope, also after an error or an interrupt. An existing folder is kept. The folder is locked
/// until the end of the scope or the process, so that all results are from one process.
class ResultFolder {
 public:
  /// \throws IoError if files cannot be written into it, or another ResultFolder has locked it
  explicit ResultFolder(const std::filesystem::path& path);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  std::vector<std::filesystem::path> made_{};  ///< each above the next
  std::shared_ptr<void> lock_{};
};

/// A new folder in the system's folder for temporary files, removed with its contents.
///
/// \throws IoError if it cannot be created
class TemporaryFolder {
 public:
  /// \param name  beginning of the folder's name
  explicit TemporaryFolder(std::string_view name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Removes the temporary files of all AtomicFiles that are not committed, all TemporaryFolders, and
/// all created folders that are empty. For the end of an interrupted process: afterwards no file
/// can be started or committed.
void discard_unfinished_files();

/// A file without a name, for reading and writing, which is deleted when it is closed.
struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using NamelessFile = std::unique_ptr<std::FILE, CloseFile>;

/// A new file without a name in the folder of another file.
/// \throws IoError if it cannot be created
NamelessFile open_nameless_file(const std::filesystem::path& beside);

/// The largest file that is read into memory, unless the caller gives another limit [bytes]. It
/// always limits devices and pipes, such as /dev/zero.
inline constexpr std::uint64_t kLargestFile = std::uint64_t{512} << 20U;
/// For files of any size.
inline constexpr std::uint64_t kAnySize = std::numeric_limits<std::uint64_t>::max();

/// The bytes of a file.
/// \param limit  largest size of the file [bytes]
/// \throws InputError if it cannot be opened or is larger; IoError if reading it fails
std::string read_file(const std::filesystem::path& path, std::uint64_t limit = kLargestFile);

}  // namespace silvafit
