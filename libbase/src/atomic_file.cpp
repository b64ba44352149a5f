// SPDX-License-Identifier: MIT
#include "silvafit/base/atomic_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <iterator>
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

[[noreturn]] void cannot(const char* verb, const fs::path& path, int error_number) {
  throw InputError(fmt::format("cannot {} ({})", verb, std::strerror(error_number)),
                   {.file = path.string()});
}

}  // namespace

AtomicFile::AtomicFile(fs::path target)
    : target_(std::move(target)), temporary_(temporary_beside(target_)) {
  if (target_.has_parent_path()) {
    std::error_code error;
    fs::create_directories(target_.parent_path(), error);
    if (error) cannot("make the folder", target_.parent_path(), error.value());
  }
  stream_.open(temporary_, std::ios::binary | std::ios::trunc);
  if (!stream_) cannot("write", target_, errno);
}

AtomicFile::~AtomicFile() {
  if (committed_) return;
  stream_.close();
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  stream_.close();
  if (!stream_) cannot("write", target_, errno);
  std::error_code error;
  fs::rename(temporary_, target_, error);
  if (error) cannot("write", target_, error.value());
  committed_ = true;
}

void write_file(const fs::path& path, std::string_view bytes) {
  AtomicFile file(path);
  file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.commit();
}

std::string read_file(const fs::path& path) {
  if (fs::is_directory(path)) cannot("read", path, EISDIR);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) cannot("read", path, errno);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (stream.bad()) cannot("read", path, errno);
  return bytes;
}

}  // namespace silvafit
