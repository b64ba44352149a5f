// SPDX-License-Identifier: MIT
// Bytes and JSON that are written to a file later: the first ones in memory, more on disk.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

/// A string in quotation marks, with JSON's escapes.
std::string json_quoted(const std::string& text);

/// An array of three numbers, in as many digits as they need.
std::string json_triple(const std::array<double, 3>& values);

/// The items of a JSON array, with commas between them.
class ArraySpool {
 public:
  /// \param beside  as for Spool
  explicit ArraySpool(const std::filesystem::path& beside) : spool_(beside) {}

  /// \param item  as JSON
  /// \returns its number
  std::size_t add(const std::string& item);
  std::size_t count() const { return count_; }
  Spool& spool() { return spool_; }

 private:
  Spool spool_;
  std::size_t count_ = 0;
};

/// Text and spools in sequence. The spools must outlive it.
class Pieces {
 public:
  void add(std::string text) { pieces_.emplace_back(std::move(text), nullptr); }
  void add(Spool& spool) { pieces_.emplace_back(std::string(), &spool); }

  /// Bytes of all of them.
  std::size_t size() const;
  /// \throws IoError if the disk fails
  void write_to(std::ostream& to) const;

 private:
  std::vector<std::pair<std::string, Spool*>> pieces_;
};

}  // namespace silvafit::tree
