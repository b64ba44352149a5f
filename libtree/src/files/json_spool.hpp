// SPDX-License-Identifier: MIT
// JSON that is too long for memory while it is written.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "files/spool.hpp"

namespace silvafit::tree {

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
