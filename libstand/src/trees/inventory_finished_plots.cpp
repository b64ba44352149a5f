// SPDX-License-Identifier: MIT
#include "trees/inventory_finished_plots.hpp"

#include <algorithm>
#include <functional>

namespace silvafit::stand {
namespace {

std::uint64_t hash_of(std::string_view plot) { return std::hash<std::string_view>()(plot); }

}  // namespace

void FinishedPlots::add(std::span<const std::string> plots) {
  const auto before = static_cast<std::ptrdiff_t>(hashes_.size());
  for (const std::string& plot : plots) hashes_.push_back(hash_of(plot));
  const auto added = hashes_.begin() + before;
  std::sort(added, hashes_.end());
  std::inplace_merge(hashes_.begin(), added, hashes_.end());
}

bool FinishedPlots::contains(std::string_view plot) const {
  return std::ranges::binary_search(hashes_, hash_of(plot));
}

}  // namespace silvafit::stand
