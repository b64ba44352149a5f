// SPDX-License-Identifier: MIT
// Files that are written whole or not at all.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit {

/// A file under construction: what is written goes to a temporary file beside the target, which
/// takes the target's name at commit(). Without commit the temporary file is removed, with the
/// folders that were made for it, and the target stays as it was.
///
/// The temporary file has a random name that no other process can have or guess. A target that is a
/// symbolic link stays one, and the file that it names is replaced; a replaced file keeps its
/// permissions. Devices and pipes, such as /dev/stdout, are written to as it comes.
///
/// \throws IoError if the folder cannot be written to, or the disk is full
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream();
  /// Closes the file and gives it its name, when its bytes are on the disk.
  void commit();

 private:
  friend void commit_together(const std::vector<AtomicFile*>& files);
  struct State;
  std::unique_ptr<State> state_;
};

/// Commits files that belong together: all are written whole before the first of them gets its
/// name, one after the other in this order. discard_unfinished_files() leaves all or none; where
/// the process is killed, the earlier ones may be new beside later ones that are old.
/// \throws IoError as AtomicFile::commit()
void commit_together(const std::vector<AtomicFile*>& files);

/// Writes the bytes to the path, whole or not at all; folders above it are made.
/// \throws IoError if that is not possible
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes sure that files can be written into a folder, or could be once it is made.
/// \throws IoError if not
void require_writable_folder(const std::filesystem::path& folder);

/// A folder for results: what it makes and nobody writes into is gone at the end of its scope, such
/// as after an error, and after an interrupt. A folder that was there before stays. The folder is
/// locked (flock) until the scope or the process ends, so that the results are those of one
/// process.
class ResultFolder {
 public:
  /// \throws IoError if files cannot be written into it, or if another ResultFolder has it
  explicit ResultFolder(const std::filesystem::path& path);
  ~ResultFolder();
  ResultFolder(const ResultFolder&) = delete;
  ResultFolder& operator=(const ResultFolder&) = delete;

 private:
  struct Lock;

  std::vector<std::filesystem::path> made_{};  ///< each above the next
  std::unique_ptr<Lock> lock_;
};

/// A folder of its own in the system's folder for temporary files, removed with all that is in it.
///
/// \throws IoError if none can be made
class TemporaryFolder {
 public:
  /// \param name  what the folder's name begins with
  explicit TemporaryFolder(std::string_view name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Removes the temporary files of all AtomicFiles that are not committed, all TemporaryFolders, and
/// all folders that were made and are empty. For the end of a process that is interrupted: none can
/// be begun or committed after it.
void discard_unfinished_files();

/// A new file beside another one that has no name and so is gone when its descriptor is closed.
/// \return its descriptor, for reading and writing
/// \throws IoError if none can be made
int open_nameless_file(const std::filesystem::path& beside);

/// The largest file that is read as a whole, unless its reader names another limit [bytes]. No more
/// is read of a device or pipe, such as /dev/zero, whatever the reader's limit.
inline constexpr std::uint64_t kLargestFile = std::uint64_t{512} << 20U;
/// For files whose reader is not limited by their size.
inline constexpr std::uint64_t kAnySize = std::numeric_limits<std::uint64_t>::max();

/// The bytes of a file.
/// \param limit  largest size of the file [bytes]
/// \throws InputError if it cannot be opened or is larger; IoError if reading it fails
std::string read_file(const std::filesystem::path& path, std::uint64_t limit = kLargestFile);

}  // namespace silvafit
