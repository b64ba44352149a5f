// SPDX-License-Identifier: MIT
#include "silvafit/base/text.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace silvafit {
namespace {

/// The bits that one byte of UTF-8 after the first adds to a code point.
constexpr unsigned kBitsOfByte = 6;

bool is_single_byte_control(unsigned char byte) {
  return (byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F;
}

/// Controls of terminals (C1), and those that change the direction of text: after them the end of a
/// line may look like its beginning.
bool is_wide_control(std::uint32_t code_point) {
  const auto is_between = [code_point](std::uint32_t first, std::uint32_t last) {
    return first <= code_point && code_point <= last;
  };
  return is_between(0x80, 0x9F) || code_point == 0x061C || is_between(0x200E, 0x200F) ||
         is_between(0x202A, 0x202E) || is_between(0x2066, 0x2069);
}

/// The code point of two or three bytes at the position, and their number; no bytes if there is
/// none.
struct WideCharacter {
  std::uint32_t code_point = 0;
  std::size_t bytes = 0;
};

WideCharacter wide_character_at(std::string_view text, std::size_t position) {
  const auto first = static_cast<unsigned char>(text[position]);
  const bool has_two = (first & 0xE0U) == 0xC0U;
  const bool has_three = (first & 0xF0U) == 0xE0U;
  if (!has_two && !has_three) return {};
  const std::size_t bytes = has_two ? 2 : 3;
  if (text.size() - position < bytes) return {};
  std::uint32_t code_point = first & (has_two ? 0x1FU : 0x0FU);
  for (std::size_t i = 1; i < bytes; ++i) {
    const auto next = static_cast<unsigned char>(text[position + i]);
    if ((next & 0xC0U) != 0x80U) return {};
    code_point = (code_point << kBitsOfByte) | (next & 0x3FU);
  }
  return {code_point, bytes};
}

}  // namespace

std::string with_visible_controls(std::string_view text) {
  std::string visible;
  visible.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (is_single_byte_control(byte)) {
      visible += byte == 0x7F ? "\\u007f" : fmt::format("\\x{:02x}", byte);
      continue;
    }
    const WideCharacter wide = wide_character_at(text, i);
    if (wide.bytes > 0 && is_wide_control(wide.code_point)) {
      visible += fmt::format("\\u{:04x}", wide.code_point);
      i += wide.bytes - 1;
    } else {
      visible += text[i];
    }
  }
  return visible;
}

std::string counted(std::size_t count, std::string_view one, std::string_view many) {
  return std::to_string(count) + " " + std::string(count == 1 ? one : many);
}

std::string enumerated(const std::vector<std::string>& names, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? fmt::format(" {} ", last) : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace silvafit
