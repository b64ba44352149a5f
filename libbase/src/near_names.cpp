// SPDX-License-Identifier: MIT
#include "silvafit/base/near_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace silvafit {
namespace {

constexpr std::size_t kShortest = 3;

/// Small letters and digits only.
std::string letters_of(std::string_view name) {
  std::string letters;
  for (const char byte : name) {
    const auto code = static_cast<unsigned char>(byte);
    if (code >= 0x80U || std::isalnum(code) != 0) letters += static_cast<char>(std::tolower(code));
  }
  return letters;
}

template <class Condition>
std::vector<std::string> chosen(std::span<const std::string> names, Condition holds) {
  std::vector<std::string> result;
  std::ranges::copy_if(names, std::back_inserter(result), holds);
  return result;
}

}  // namespace

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

std::string did_you_mean(std::string_view name, const std::vector<std::string>& names) {
  const std::string nearest = nearest_name(name, names);
  if (!nearest.empty()) return fmt::format("; did you mean {}?", nearest);
  return names.empty() ? std::string() : fmt::format("; available: {}", fmt::join(names, ", "));
}

bool is_slip_of(std::string_view name, std::string_view meant) {
  const std::string letters = letters_of(name);
  if (letters.size() > 1 && letters == letters_of(meant)) return name != meant;
  return name.size() >= kShortest && meant.size() >= kShortest && slips_between(name, meant) == 1;
}

bool is_abbreviation(std::string_view one, std::string_view other) {
  std::string shorter = letters_of(one);
  std::string longer = letters_of(other);
  if (shorter.size() > longer.size()) shorter.swap(longer);
  if (shorter.size() < 2 || shorter.size() == longer.size() || shorter[0] != longer[0]) {
    return false;
  }
  std::size_t found = 0;
  for (const char letter : longer) {
    if (found < shorter.size() && shorter[found] == letter) ++found;
  }
  return found == shorter.size();
}

std::vector<std::string> names_near(std::string_view name, std::span<const std::string> names) {
  std::vector<std::string> near =
      chosen(names, [&](const std::string& other) { return is_slip_of(name, other); });
  if (!near.empty()) return near;
  near = chosen(names, [&](const std::string& other) { return is_abbreviation(name, other); });
  if (!near.empty() || name.size() < kShortest) return near;
  const std::string nearest = nearest_name(name, {names.begin(), names.end()});
  if (!nearest.empty()) near.push_back(nearest);
  return near;
}

}  // namespace silvafit
