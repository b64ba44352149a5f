// SPDX-License-Identifier: MIT
#include "unfinished_files.hpp"

#include <cerrno>
#include <random>
#include <string_view>

#include "silvafit/base/system.hpp"

namespace silvafit {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLetters = 6;
constexpr std::size_t kLongestName = 255;  // of Linux' file systems, in bytes

/// Random letters that nobody can guess.
std::string random_letters() {
  constexpr std::string_view kAlphabet = "abcdefghijklmnopqrstuvwxyz0123456789";
  std::random_device bits;
  std::string letters;
  for (std::size_t i = 0; i < kLetters; ++i) letters += kAlphabet[bits() % kAlphabet.size()];
  return letters;
}

/// A new name beside a target that `make` accepts.
/// \return what it made, or its failure, with the reason in errno
template <typename Make>
auto make_named(const fs::path& target, std::string_view ending, fs::path& path, Make make) {
  const std::size_t added = 1 + kLetters + ending.size();
  const std::string name = target.filename().string().substr(0, kLongestName - added);
  constexpr int kTries = 100;
  for (int i = 1;; ++i) {
    path = target.parent_path() / (name + "." + random_letters() + std::string(ending));
    errno = 0;
    const auto made = make(path);
    if (errno != EEXIST || i == kTries) return made;
  }
}

}  // namespace

UnfinishedFiles& UnfinishedFiles::of_process() {
  // Never destroyed: an interrupt may come while the process ends.
  static auto& files = *new UnfinishedFiles;
  return files;
}

UnfinishedFiles::Opened UnfinishedFiles::make_file(const fs::path& target, fs::perms permissions) {
  const std::lock_guard lock(mutex_);
  Opened opened;
  opened.descriptor = make_named(target, ".part", opened.path, [permissions](const fs::path& path) {
    return system::open_new(path, permissions);
  });
  if (opened.descriptor >= 0) paths_.insert(opened.path);
  return opened;
}

std::FILE* UnfinishedFiles::make_nameless_file(const fs::path& beside) {
  const std::lock_guard lock(mutex_);
  fs::path path;
  return make_named(beside, ".spool", path, system::open_nameless);
}

fs::path UnfinishedFiles::make_temporary_folder(const fs::path& beginning) {
  const std::lock_guard lock(mutex_);
  fs::path path;
  if (!make_named(beginning, "", path, system::make_own_folder)) return {};
  paths_.insert(path);
  return path;
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
  std::error_code ignored;
  for (auto folder = folders.rbegin(); folder != folders.rend(); ++folder) {
    fs::remove(*folder, ignored);
  }
}

}  // namespace silvafit
