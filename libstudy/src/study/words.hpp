// SPDX-License-Identifier: MIT
// Settings with a few possible words as values.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::study {

/// A word and its value.
template <class Value>
using Word = std::pair<std::string_view, Value>;

/// The value of a word.
/// \param field  of the settings
/// \throws UsageError that lists the words if it is unknown
template <class Words>
auto meaning_of(const std::string& word, const Words& words, const char* field) {
  for (const auto& [known, value] : words) {
    if (known == word) return value;
  }
  std::vector<std::string_view> all;
  for (const auto& [known, value] : words) all.push_back(known);
  throw UsageError(fmt::format("'{}' is not one of {}", word, fmt::join(all, ", ")),
                   {.column = field});
}

}  // namespace silvafit::study
