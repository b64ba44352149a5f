// SPDX-License-Identifier: MIT
// Bytes that are written to a file later: the first ones in memory, more on disk.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <string_view>

#include "silvafit/base/atomic_file.hpp"

namespace silvafit::tree {

/// Grows at its end and is read once. Bytes beyond the memory limit go to an unnamed temporary file
/// in the folder of the target, so that no file is left when the program is stopped.
class Spool {
 public:
  /// \param beside  the file that will contain the bytes
  explicit Spool(std::filesystem::path beside);

  void append(std::string_view bytes);
  void append(const void* data, std::size_t size);
  std::size_t size() const { return size_; }

  /// Hands all bytes over, in pieces.
  /// \throws IoError if the disk fails
  void read(const std::function<void(std::string_view)>& take);
  /// \throws IoError if the disk fails
  void copy_to(std::ostream& to);

 private:
  void spill();

  std::filesystem::path beside_;
  std::string memory_;
  NamelessFile file_;
  std::size_t size_ = 0;
};

}  // namespace silvafit::tree
