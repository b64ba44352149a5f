// SPDX-License-Identifier: MIT
// Files that are written whole or not at all.
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace silvafit {

/// A file under construction: what is written goes to a temporary file beside the target, which
/// takes the target's name at commit(). Without commit the temporary file is removed and the target
/// stays as it was. Devices and pipes, such as /dev/stdout, have no such place: what is written
/// goes to them as it comes.
///
/// \throws InputError if the folder cannot be written to, or the disk is full
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path target);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return stream_; }
  /// Closes the file and gives it its name.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path temporary_;  ///< empty: the target is written to
  std::ofstream stream_;
  bool committed_ = false;
};

/// Writes the bytes to the path, whole or not at all; folders above it are made.
/// \throws InputError if that is not possible
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// Makes sure that files can be written into a folder, which is made if it is not there.
/// \throws InputError if not
void require_writable_folder(const std::filesystem::path& folder);

/// A folder of its own in the system's folder for temporary files, removed with all that is in it.
///
/// \throws InputError if none can be made
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

/// Removes the temporary files of all AtomicFiles that are not committed, and all TemporaryFolders.
/// For the end of a process that is interrupted: none can be begun or committed after it.
void discard_unfinished_files();

/// The bytes of a file.
/// \throws InputError if it cannot be read
std::string read_file(const std::filesystem::path& path);

}  // namespace silvafit
