// SPDX-License-Identifier: MIT
// The plots that were read so far from a file that is read plot by plot.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::stand {

/// Stores plots as hashes of 64 bits: of ten million plots, two have the same
/// hash with a probability of 3e-6.
class FinishedPlots {
 public:
  void add(std::span<const std::string> plots);
  bool contains(std::string_view plot) const;

 private:
  std::vector<std::uint64_t> hashes_{};  ///< sorted
};

}  // namespace silvafit::stand
