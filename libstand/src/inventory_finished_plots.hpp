// SPDX-License-Identifier: MIT
// Plots of a file that is read plot by plot, as far as it was read.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::stand {

/// Remembers plots in 8 bytes each, by hashes of 64 bits: of ten million plots, two have the same
/// hash with a probability of 3e-6.
class FinishedPlots {
 public:
  void add(std::span<const std::string> plots);
  bool contains(std::string_view plot) const;

 private:
  std::vector<std::uint64_t> hashes_{};  ///< sorted
};

}  // namespace silvafit::stand
