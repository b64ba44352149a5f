// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>

#include "study/chosen_fits.hpp"

using silvafit::study::letter_groups;
using Letters = std::vector<std::string>;

namespace {

/// A symmetric relation of n things from its pairs.
std::vector<std::vector<bool>> relation(
    std::size_t n, const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
  std::vector<std::vector<bool>> result(n, std::vector<bool>(n, false));
  for (const auto& [i, j] : pairs) result[i][j] = result[j][i] = true;
  return result;
}

}  // namespace

TEST_CASE("things that do not differ share one letter, those that do have their own") {
  CHECK(letter_groups(relation(3, {})) == Letters{"a", "a", "a"});
  CHECK(letter_groups(relation(3, {{0, 1}, {0, 2}, {1, 2}})) == Letters{"a", "b", "c"});
  CHECK(letter_groups(relation(3, {{0, 1}, {0, 2}})) == Letters{"a", "b", "b"});
  CHECK(letter_groups({}).empty());
}

TEST_CASE("a thing between two that differ has the letters of both") {
  CHECK(letter_groups(relation(3, {{0, 2}})) == Letters{"a", "ab", "b"});
}

TEST_CASE("two things share a letter if and only if they do not differ") {
  // All relations of five things.
  constexpr std::size_t kThings = 5;
  constexpr unsigned kPairs = kThings * (kThings - 1) / 2;
  for (unsigned bits = 0; bits < (1U << kPairs); ++bits) {
    std::vector<std::pair<std::size_t, std::size_t>> pairs;
    unsigned bit = 0;
    for (std::size_t i = 0; i < kThings; ++i) {
      for (std::size_t j = i + 1; j < kThings; ++j, ++bit) {
        if ((bits >> bit & 1U) != 0) pairs.emplace_back(i, j);
      }
    }
    const auto differs = relation(kThings, pairs);
    const Letters letters = letter_groups(differs);
    for (std::size_t i = 0; i < kThings; ++i) {
      for (std::size_t j = i + 1; j < kThings; ++j) {
        const bool share = letters[i].find_first_of(letters[j]) != std::string::npos;
        if (share == differs[i][j]) FAIL("relation " << bits << ", things " << i << " and " << j);
      }
    }
  }
  SUCCEED();
}
