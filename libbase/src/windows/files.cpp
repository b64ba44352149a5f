// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <fmt/format.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "silvafit/base/system.hpp"

namespace silvafit::system {
namespace {

namespace fs = std::filesystem;

/// The number of bytes of a call, which takes an unsigned int.
unsigned at_most(std::size_t count) {
  constexpr std::size_t kMost = std::numeric_limits<int>::max();
  return static_cast<unsigned>(std::min(count, kMost));
}

/// The error number of C for the last error of Windows.
int last_error() {
  const std::error_code error(static_cast<int>(::GetLastError()), std::system_category());
  // Another program has opened the file.
  if (error.value() == ERROR_SHARING_VIOLATION) return EACCES;
  return error.default_error_condition().value();
}

}  // namespace

int open_to_read(const fs::path& file) {
  std::error_code ignored;
  const int descriptor = ::_wopen(file.c_str(), _O_RDONLY | _O_BINARY | _O_NOINHERIT);
  if (descriptor < 0 && fs::is_directory(file, ignored)) errno = EISDIR;
  return descriptor;
}

int open_to_append(const fs::path& file) {
  return ::_wopen(file.c_str(), _O_WRONLY | _O_APPEND | _O_BINARY | _O_NOINHERIT);
}

int open_new(const fs::path& file, fs::perms /*permissions*/) {
  // Shared with those who remove it, so that an interrupt can.
  const HANDLE handle = ::CreateFileW(file.c_str(),
                                      GENERIC_READ | GENERIC_WRITE,
                                      FILE_SHARE_READ | FILE_SHARE_DELETE,
                                      nullptr,
                                      CREATE_NEW,
                                      FILE_ATTRIBUTE_NORMAL,
                                      nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    errno = last_error();
    return -1;
  }
  return ::_open_osfhandle(reinterpret_cast<std::intptr_t>(handle), _O_BINARY);
}

std::FILE* open_nameless(const fs::path& file) {
  constexpr int kFlags =
      _O_RDWR | _O_CREAT | _O_EXCL | _O_BINARY | _O_NOINHERIT | _O_TEMPORARY | _O_SHORT_LIVED;
  const int descriptor = ::_wopen(file.c_str(), kFlags, _S_IREAD | _S_IWRITE);
  if (descriptor < 0) return nullptr;
  std::FILE* const opened = ::_fdopen(descriptor, "w+b");
  if (opened == nullptr) close(descriptor);
  return opened;
}

std::ptrdiff_t read(int descriptor, char* bytes, std::size_t count) {
  return ::_read(descriptor, bytes, at_most(count));
}

std::ptrdiff_t write(int descriptor, const char* bytes, std::size_t count) {
  return ::_write(descriptor, bytes, at_most(count));
}

bool close(int descriptor) { return ::_close(descriptor) == 0; }

std::optional<std::uint64_t> file_size(int descriptor) {
  struct _stat64 status {};
  if (::_fstat64(descriptor, &status) != 0 || (status.st_mode & _S_IFREG) == 0) return std::nullopt;
  return static_cast<std::uint64_t>(status.st_size);
}

// A new file has the permissions of its folder.
bool set_permissions(int /*descriptor*/, fs::perms /*permissions*/) { return true; }

bool flush_to_disk(int descriptor) { return ::_commit(descriptor) == 0; }

// NTFS keeps names in a journal.
bool flush_folder(const fs::path& /*folder*/) { return true; }

// The folder for temporary files belongs to the user.
bool make_own_folder(const fs::path& folder) {
  if (::CreateDirectoryW(folder.c_str(), nullptr) != 0) return true;
  errno = last_error();
  return false;
}

bool lock_folder(const fs::path& folder, std::shared_ptr<void>& lock) {
  const HANDLE opened = ::CreateFileW(folder.c_str(),
                                      0,
                                      FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                                      nullptr,
                                      OPEN_EXISTING,
                                      FILE_FLAG_BACKUP_SEMANTICS,
                                      nullptr);
  if (opened == INVALID_HANDLE_VALUE) return true;
  BY_HANDLE_FILE_INFORMATION about{};
  const bool is_known = ::GetFileInformationByHandle(opened, &about) != 0;
  ::CloseHandle(opened);
  if (!is_known) return true;
  // Folders cannot be locked. All names of a folder lead to one number, and its mutex goes with the
  // process; those of other computers that share the folder are not seen.
  const std::string name = fmt::format("silvafit-{:x}-{:x}-{:x}",
                                       about.dwVolumeSerialNumber,
                                       about.nFileIndexHigh,
                                       about.nFileIndexLow);
  const HANDLE mutex = ::CreateMutexA(nullptr, FALSE, name.c_str());
  if (mutex == nullptr) return true;
  const bool is_first = ::GetLastError() != ERROR_ALREADY_EXISTS;
  lock = std::shared_ptr<void>(mutex, ::CloseHandle);
  return is_first;
}

std::string reason(int error_number) {
  if (error_number != EACCES) return std::strerror(error_number);
  return "no permission, or another program such as Excel has the file open; close it there";
}

}  // namespace silvafit::system
