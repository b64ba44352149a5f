// SPDX-License-Identifier: MIT
#include "silvafit/base/words.hpp"

#include <algorithm>
#include <cctype>

namespace silvafit {
namespace {

char in_lower_case(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

}  // namespace

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = in_lower_case(c);
  return lower;
}

bool are_equal_words(std::string_view left, std::string_view right) {
  return std::ranges::equal(
      left, right, [](char one, char other) { return in_lower_case(one) == in_lower_case(other); });
}

bool has_word(std::string_view list, std::string_view word) {
  while (!list.empty()) {
    const std::string_view first = list.substr(0, list.find(' '));
    if (first == word) return true;
    list.remove_prefix(first.size() < list.size() ? first.size() + 1 : first.size());
  }
  return false;
}

}  // namespace silvafit
