// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "silvafit/base/system.hpp"

namespace silvafit::system {
namespace {

namespace fs = std::filesystem;

mode_t mode_of(fs::perms permissions) { return static_cast<mode_t>(permissions); }

int open_folder(const fs::path& folder) {
  return ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

}  // namespace

int open_to_read(const fs::path& file) { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC); }

int open_to_append(const fs::path& file) {
  return ::open(file.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
}

int open_new(const fs::path& file, fs::perms permissions) {
  constexpr int kFlags = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  return ::open(file.c_str(), kFlags, mode_of(permissions));
}

std::FILE* open_nameless(const fs::path& file) {
  const int descriptor = open_new(file, fs::perms::owner_read | fs::perms::owner_write);
  if (descriptor < 0) return nullptr;
  ::unlink(file.c_str());
  std::FILE* const opened = ::fdopen(descriptor, "w+b");
  if (opened == nullptr) close(descriptor);
  return opened;
}

std::ptrdiff_t read(int descriptor, char* bytes, std::size_t count) {
  while (true) {
    const ssize_t done = ::read(descriptor, bytes, count);
    if (done >= 0 || errno != EINTR) return done;
  }
}

std::ptrdiff_t write(int descriptor, const char* bytes, std::size_t count) {
  while (true) {
    const ssize_t done = ::write(descriptor, bytes, count);
    if (done >= 0 || errno != EINTR) return done;
  }
}

bool close(int descriptor) { return ::close(descriptor) == 0; }

std::optional<std::uint64_t> file_size(int descriptor) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

bool set_permissions(int descriptor, fs::perms permissions) {
  return ::fchmod(descriptor, mode_of(permissions)) == 0;
}

bool flush_to_disk(int descriptor) {
  return ::fsync(descriptor) == 0 || errno == EINVAL || errno == ENOTSUP || errno == ENOSYS;
}

bool flush_folder(const fs::path& folder) {
  const int descriptor = open_folder(folder);
  if (descriptor < 0) return true;
  const bool is_flushed = flush_to_disk(descriptor);
  const int error_number = errno;
  close(descriptor);
  errno = error_number;
  return is_flushed;
}

bool make_own_folder(const fs::path& folder) { return ::mkdir(folder.c_str(), S_IRWXU) == 0; }

bool lock_folder(const fs::path& folder, std::shared_ptr<void>& lock) {
  const int descriptor = open_folder(folder);
  if (descriptor < 0) return true;
  lock = std::shared_ptr<void>(nullptr, [descriptor](void*) { close(descriptor); });
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

std::string reason(int error_number) { return std::strerror(error_number); }

}  // namespace silvafit::system
