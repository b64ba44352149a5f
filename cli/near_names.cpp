// SPDX-License-Identifier: MIT
#include "near_names.hpp"

#include <algorithm>

namespace silvafit::cli {

std::size_t slips_between(std::string_view one, std::string_view other) {
  // Row i has the distances of the first i letters of one; swaps look two rows back.
  std::vector<std::size_t> before(other.size() + 1);
  std::vector<std::size_t> last(other.size() + 1);
  std::vector<std::size_t> row(other.size() + 1);
  for (std::size_t j = 0; j <= other.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= one.size(); ++i) {
    before.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= other.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (one[i - 1] == other[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool is_swap =
          i > 1 && j > 1 && one[i - 1] == other[j - 2] && one[i - 2] == other[j - 1];
      if (is_swap) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[other.size()];
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
  std::string nearest;
  std::size_t fewest = 1 + std::max<std::size_t>(1, name.size() / 3);
  for (const std::string& candidate : names) {
    const std::size_t slips = slips_between(name, candidate);
    if (slips >= fewest) continue;
    fewest = slips;
    nearest = candidate;
  }
  return nearest;
}

bool is_slip_of(std::string_view name, std::string_view meant) {
  constexpr std::size_t kShortest = 3;
  return name.size() >= kShortest && meant.size() >= kShortest && slips_between(name, meant) == 1;
}

}  // namespace silvafit::cli
