// SPDX-License-Identifier: MIT
// The words of enumerations in settings, files and tables.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "silvafit/base/error.hpp"

namespace silvafit {

/// An enumeration whose values are written as words: beside it is a function words_of(E) with an
/// array of them, in the order of the values.
template <typename E>
concept Worded = std::is_enum_v<E> && requires(E value) {
  { words_of(value)[0] } -> std::convertible_to<std::string_view>;
};

template <Worded E>
std::string word_of(E value) {
  return std::string(words_of(value).at(static_cast<std::size_t>(value)));
}

/// All values, in their order.
template <Worded E>
constexpr auto all_values() {
  std::array<E, words_of(E{}).size()> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<E>(i);
  return values;
}

/// The value of a word; none if there is no such word.
template <Worded E>
std::optional<E> find_word(std::string_view word) {
  const auto words = words_of(E{});
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) return std::nullopt;
  return static_cast<E>(found - words.begin());
}

/// The value of a word.
/// \param what  what it is, for the message: "criterion"
/// \throws UsageError with the available words if there is no such word
template <Worded E>
E value_of(std::string_view word, std::string_view what) {
  if (const std::optional<E> value = find_word<E>(word)) return *value;
  std::string available;
  for (const std::string_view one : words_of(E{})) {
    available.append(available.empty() ? "" : ", ").append(one);
  }
  throw UsageError(std::string("unknown ").append(what).append(" '").append(word) +
                   "'; available: " + available);
}

}  // namespace silvafit
