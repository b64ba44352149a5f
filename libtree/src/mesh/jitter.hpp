// SPDX-License-Identifier: MIT
// Fast random numbers for details of foliage.
#pragma once

#include <cstdint>

#include "silvafit/base/random.hpp"

namespace silvafit::tree {

/// Random numbers for details without effect on measurements: many from one draw of 64 bits.
class Jitter {
 public:
  explicit Jitter(Random& random) : state_(random.bits() | 1U) {}
  /// In [-1, 1).
  double next() {
    // Knuth's multiplier of linear congruential generators; the high bits are the random ones.
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(static_cast<std::int64_t>(state_) >> 11) * 0x1.0p-52;
  }

 private:
  std::uint64_t state_;
};

}  // namespace silvafit::tree
