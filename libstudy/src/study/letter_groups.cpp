// SPDX-License-Identifier: MIT
#include "study/letter_groups.hpp"

#include <algorithm>
#include <cstddef>

namespace silvafit::study {
namespace {

using Set = std::vector<bool>;

bool is_within(const Set& inner, const Set& outer) {
  for (std::size_t k = 0; k < inner.size(); ++k) {
    if (inner[k] && !outer[k]) return false;
  }
  return true;
}

/// Sets that contain both members are split into one without each.
std::vector<Set> split_between(const std::vector<Set>& sets,
                               std::size_t first,
                               std::size_t second) {
  std::vector<Set> result;
  for (const Set& set : sets) {
    result.push_back(set);
    if (!set[first] || !set[second]) continue;
    result.back()[second] = false;
    result.push_back(set);
    result.back()[first] = false;
  }
  return result;
}

/// Subsets of other sets are removed; of equal sets the first remains.
std::vector<Set> without_subsets(const std::vector<Set>& sets) {
  std::vector<Set> result;
  for (std::size_t a = 0; a < sets.size(); ++a) {
    bool is_needed = true;
    for (std::size_t b = 0; b < sets.size() && is_needed; ++b) {
      if (a != b && is_within(sets[a], sets[b])) is_needed = sets[a] == sets[b] && a < b;
    }
    if (is_needed) result.push_back(sets[a]);
  }
  return result;
}

}  // namespace

std::vector<std::string> letter_groups(const std::vector<std::vector<bool>>& differs) {
  const std::size_t n = differs.size();
  std::vector<Set> sets{Set(n, true)};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      if (differs[i][j]) sets = without_subsets(split_between(sets, i, j));
    }
  }
  std::vector<std::string> letters(n);
  for (std::size_t s = 0; s < sets.size(); ++s) {
    for (std::size_t k = 0; k < n; ++k) {
      if (sets[s][k]) letters[k] += static_cast<char>('a' + s);
    }
  }
  return letters;
}

}  // namespace silvafit::study
