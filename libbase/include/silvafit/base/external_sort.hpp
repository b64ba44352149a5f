// SPDX-License-Identifier: MIT
// Sorting of more records than fit into memory.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace silvafit {

/// Sorts records by a key of two numbers; records with equal keys keep their order.
///
/// Records are collected in memory. When they exceed the limit, they are sorted and written to a
/// temporary file in the system's folder for temporary files (TMPDIR); at the end these files are
/// merged. They need as much space as all records, and 20 bytes for each.
/// \throws IoError if the disk is full or fails
class ExternalSort {
 public:
  struct Key {
    std::uint64_t first = 0;
    std::uint64_t second = 0;
    auto operator<=>(const Key&) const = default;
  };

  /// \param memory  most bytes of records and keys in memory
  explicit ExternalSort(std::size_t memory = std::size_t{64} << 20U);
  ~ExternalSort();
  ExternalSort(ExternalSort&&) noexcept;
  ExternalSort& operator=(ExternalSort&&) noexcept;

  /// Adds a record; not after the first next().
  void add(Key key, std::string_view record);
  /// The next record in order; false after the last.
  bool next(Key& key, std::string& record);
  /// Number of files written so far.
  std::size_t runs() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace silvafit
