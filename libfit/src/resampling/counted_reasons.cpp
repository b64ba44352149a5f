// SPDX-License-Identifier: MIT
#include "resampling/counted_reasons.hpp"

#include <algorithm>
#include <cctype>

namespace silvafit::fit {

std::vector<CountedReason> ReasonCounts::sorted() const {
  std::vector<CountedReason> result;
  for (const auto& [reason, count] : counts_) result.push_back({reason, count});
  std::ranges::stable_sort(result, std::ranges::greater{}, &CountedReason::replicates);
  return result;
}

std::string ReasonCounts::without_numbers(std::string_view text) {
  const auto is_digit = [&](std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
  };
  const auto is_letter = [&](std::size_t i) {
    return i < text.size() &&
           (text[i] == '_' || std::isalpha(static_cast<unsigned char>(text[i])) != 0);
  };
  std::string result;
  // A digit within a name, as in "b10" or "b_0", is part of it.
  bool is_name = false;
  for (std::size_t i = 0; i < text.size();) {
    if (!is_digit(i) || is_name) {
      is_name = is_letter(i) || (is_name && is_digit(i));
      result += text[i++];
      continue;
    }
    result += '#';
    while (is_digit(i) || (i < text.size() && text[i] == '.' && is_digit(i + 1))) ++i;
    const bool has_exponent = i < text.size() && text[i] == 'e' && i + 1 < text.size() &&
                              (text[i + 1] == '-' || text[i + 1] == '+') && is_digit(i + 2);
    if (has_exponent) {
      i += 2;
      while (is_digit(i)) ++i;
    }
  }
  return result;
}

}  // namespace silvafit::fit
