// SPDX-License-Identifier: MIT
#include "unfinished_files.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string_view>

namespace silvafit {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLetters = 6;
constexpr std::size_t kLongestName = 255;  // of Linux' file systems, in bytes

/// Random letters that nobody can guess; empty on failure, with the reason in errno.
std::string random_letters() {
  constexpr std::string_view kAlphabet = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::array<unsigned char, kLetters> bytes{};
  if (::getentropy(bytes.data(), bytes.size()) != 0) return {};
  std::string letters;
  for (const unsigned char byte : bytes) letters += kAlphabet[byte % kAlphabet.size()];
  return letters;
}

/// The descriptor of a new file; -1 on failure, with the reason in errno.
int open_new(const fs::path& target, std::string_view ending, mode_t mode, fs::path& path) {
  const std::size_t added = 1 + kLetters + ending.size();
  const std::string name = target.filename().string().substr(0, kLongestName - added);
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    const std::string letters = random_letters();
    if (letters.empty()) return -1;
    path = target.parent_path() / (name + "." + letters + std::string(ending));
    const int descriptor =
        ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
    if (descriptor >= 0 || errno != EEXIST) return descriptor;
  }
  return -1;
}

}  // namespace

UnfinishedFiles& UnfinishedFiles::of_process() {
  // Never destroyed: an interrupt may come while the process ends.
  static auto& files = *new UnfinishedFiles;
  return files;
}

UnfinishedFiles::Opened UnfinishedFiles::make_file(const fs::path& target, mode_t mode) {
  const std::lock_guard lock(mutex_);
  Opened opened;
  opened.descriptor = open_new(target, ".part", mode, opened.path);
  if (opened.descriptor >= 0) paths_.insert(opened.path);
  return opened;
}

int UnfinishedFiles::make_nameless_file(const fs::path& beside) {
  const std::lock_guard lock(mutex_);
  fs::path path;
  constexpr mode_t kOwnOnly = 0600;
  const int descriptor = open_new(beside, ".spool", kOwnOnly, path);
  if (descriptor >= 0) ::unlink(path.c_str());
  return descriptor;
}

fs::path UnfinishedFiles::make_temporary_folder(std::string pattern) {
  const std::lock_guard lock(mutex_);
  if (::mkdtemp(pattern.data()) == nullptr) return {};
  paths_.insert(pattern);
  return pattern;
}

std::error_code UnfinishedFiles::make_folders(const fs::path& folder, std::vector<fs::path>& made) {
  const std::lock_guard lock(mutex_);
  std::error_code error;
  std::vector<fs::path> missing;
  const fs::path whole = folder.lexically_normal();
  for (fs::path path = whole.has_filename() ? whole : whole.parent_path();
       !path.empty() && fs::status(path, error).type() == fs::file_type::not_found;
       path = path.parent_path()) {
    missing.push_back(path);
  }
  for (auto path = missing.rbegin(); path != missing.rend(); ++path) {
    if (!fs::create_directory(*path, error)) break;
    made.push_back(*path);
    folders_.push_back(*path);
  }
  error.clear();
  // Another process may have made the folder meanwhile; otherwise this reports the error.
  fs::create_directories(whole, error);
  return error;
}

void UnfinishedFiles::undivided(const std::function<void()>& action) {
  const std::lock_guard lock(mutex_);
  action();
}

void UnfinishedFiles::forget(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  paths_.erase(path);
}

void UnfinishedFiles::discard() {
  mutex_.lock();
  std::error_code ignored;
  for (const fs::path& path : paths_) fs::remove_all(path, ignored);
  remove_empty(folders_);
}

void remove_empty(const std::vector<fs::path>& folders) {
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {
    ::rmdir(folder->c_str());
  }
}

}  // namespace silvafit
