// SPDX-License-Identifier: MIT
// What a fuzz target is: something of the program that reads bytes it cannot trust.
#pragma once

#include <filesystem>
#include <string_view>

namespace silvafit::fuzz {

/// Reads the bytes as their reader does and uses the result. Each target defines it once.
/// \throws Error as the reader says; anything else that happens is a finding
void read(std::string_view bytes);

/// Calls read(). An error of the program's own must say something; others end the process.
void read_checked(std::string_view bytes);

/// A file in memory with the bytes, for readers that take a path. It is gone with the object.
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
