// SPDX-License-Identifier: MIT
#include "silvafit/base/atomic_file.hpp"

#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <mutex>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "silvafit/base/error.hpp"

namespace silvafit {
namespace {

namespace fs = std::filesystem;

// Two writers of one process must not share a temporary file, nor two processes.
fs::path temporary_beside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return fs::path(fmt::format("{}.{}.{}.part", target.string(), ::getpid(), counter++));
}

/// Whether what is written goes on at once, so that there is no file to put in its place: devices,
/// pipes, and names of open files such as /dev/stdout.
bool is_stream(const fs::path& target) {
  const fs::path name = target.lexically_normal();
  if (name == "/dev/stdout" || name == "/dev/stderr" || name.parent_path() == "/dev/fd")
    return true;
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

/// The temporary files and folders of this process, which a signal may end at any time.
class UnfinishedFiles {
 public:
  static UnfinishedFiles& of_process() {
    static UnfinishedFiles files;
    return files;
  }

  void add(const fs::path& path) {
    const std::lock_guard lock(mutex_);
    paths_.insert(path);
  }
  /// Makes a folder whose name is not known before; it is known here as soon as it is there.
  /// \return its path; empty if none could be made, with the reason in errno
  fs::path make_folder(std::string pattern) {
    const std::lock_guard lock(mutex_);
    if (::mkdtemp(pattern.data()) == nullptr) return {};
    paths_.insert(pattern);
    return pattern;
  }
  void remove(const fs::path& path) {
    const std::lock_guard lock(mutex_);
    paths_.erase(path);
  }
  /// Other threads that begin a file from now on wait for the end of the process.
  void discard() {
    mutex_.lock();
    std::error_code ignored;
    for (const fs::path& path : paths_) fs::remove_all(path, ignored);
  }

 private:
  std::mutex mutex_;
  std::set<fs::path> paths_;
};

[[noreturn]] void cannot(const char* verb, const fs::path& path, int error_number) {
  throw InputError(fmt::format("cannot {} ({})", verb, std::strerror(error_number)),
                   {.file = path.string()});
}

}  // namespace

AtomicFile::AtomicFile(fs::path target)
    : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  if (is_stream(target_)) {
    temporary_.clear();
    // At the end, behind what is there already.
    stream_.open(target_, std::ios::binary | std::ios::app);
    if (!stream_) cannot("write", target_, errno);
    return;
  }
  // Before anything is made, so that nothing is made after an interrupt has tidied up.
  UnfinishedFiles::of_process().add(temporary_);
  if (target_.has_parent_path()) {
    std::error_code error;
    fs::create_directories(target_.parent_path(), error);
    if (error) {
      UnfinishedFiles::of_process().remove(temporary_);
      cannot("make the folder", target_.parent_path(), error.value());
    }
  }
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (stream_) return;
  const int reason = errno;
  UnfinishedFiles::of_process().remove(temporary_);
  cannot("write", target_, reason);
}

AtomicFile::~AtomicFile() {
  if (committed_ || temporary_.empty()) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
  UnfinishedFiles::of_process().remove(temporary_);
}

void AtomicFile::commit() {
  stream_.close();
  if (!stream_) cannot("write", target_, errno);
  if (temporary_.empty()) {
    committed_ = true;
    return;
  }
  std::error_code error;
  fs::rename(temporary_, target_, error);
  committed_ = !error;
  if (error) cannot("write", target_, error.value());
  UnfinishedFiles::of_process().remove(temporary_);
}

TemporaryFolder::TemporaryFolder(std::string_view name) {
  std::error_code error;
  const fs::path all = fs::temp_directory_path(error);
  if (error) cannot("use the folder for temporary files", all, error.value());
  // mkdtemp(3) puts letters of its own in place of the last six, which have to be X.
  const fs::path pattern = all / fmt::format("{}-{:X>6}", name, "");
  path_ = UnfinishedFiles::of_process().make_folder(pattern.string());
  if (path_.empty()) cannot("make the folder", pattern, errno);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  UnfinishedFiles::of_process().remove(path_);
}

void require_writable_folder(const fs::path& folder) { const AtomicFile probe(folder / "probe"); }

void discard_unfinished_files() { UnfinishedFiles::of_process().discard(); }

void write_file(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

std::string read_file(const fs::path& path) {
  std::error_code unknown;  // opening says why, if it is that the path cannot be followed
  if (fs::is_directory(path, unknown)) cannot("read", path, EISDIR);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) cannot("read", path, errno);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (stream.bad()) cannot("read", path, errno);
  return bytes;
}

}  // namespace silvafit
