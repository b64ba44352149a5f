// SPDX-License-Identifier: MIT
// Files that tests write and that are gone afterwards.
#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

namespace silvafit::test {

/// A file with the given bytes, removed at the end of its scope.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& bytes, const std::string& extension = ".csv")
      : path_(std::filesystem::temp_directory_path() / unique_name(extension)) {
    std::ofstream(path_, std::ios::binary) << bytes;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  static std::string unique_name(const std::string& extension) {
    static std::atomic<unsigned> counter{0};
    return "silvafit-test-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) +
           extension;
  }

  std::filesystem::path path_;
};

}  // namespace silvafit::test
