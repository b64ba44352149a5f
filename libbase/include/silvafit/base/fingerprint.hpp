// SPDX-License-Identifier: MIT
// Fingerprints of files, to recognize whether a file has changed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace silvafit {

/// The fingerprint of bytes that arrive in pieces. It detects accidental changes, not forgeries.
/// Source: Fowler, Noll and Vo, FNV-1a with 64 bits (IETF draft-eastlake-fnv).
class Fingerprint {
 public:
  void add(std::string_view bytes);
  /// "fnv1a64:" and sixteen hexadecimal digits.
  std::string text() const;
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325U;
};

/// The fingerprint of all bytes.
std::string fingerprint(std::string_view bytes);

}  // namespace silvafit
