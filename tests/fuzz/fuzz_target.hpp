// SPDX-License-Identifier: MIT
// A fuzz target: a reader of the program for untrusted bytes.
#pragma once

#include <filesystem>
#include <string_view>

namespace silvafit::fuzz {

/// Reads the bytes as their reader does and uses the result. Each target defines it once.
/// \throws Error as the reader; any other failure is a finding
void read(std::string_view bytes);

/// Calls read(). An error of the program must have a message; others end the process.
void read_checked(std::string_view bytes);

/// A file in memory with the bytes, for readers that need a path. It exists as long as the object.
class FileOfBytes {
 public:
  explicit FileOfBytes(std::string_view bytes);
  ~FileOfBytes();
  FileOfBytes(const FileOfBytes&) = delete;
  FileOfBytes& operator=(const FileOfBytes&) = delete;

  std::filesystem::path path() const;

 private:
  int descriptor_;
};

}  // namespace silvafit::fuzz
