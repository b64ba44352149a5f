// SPDX-License-Identifier: MIT
#include "silvafit/base/text.hpp"

#include <fmt/format.h>

namespace silvafit {
namespace {

bool is_single_byte_control(unsigned char byte) {
  return (byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F;
}

/// U+0080 to U+009F are the byte C2 and one of 80 to 9F in UTF-8.
bool is_two_byte_control(std::string_view text, std::size_t position) {
  if (text[position] != '\xC2' || position + 1 == text.size()) return false;
  const auto second = static_cast<unsigned char>(text[position + 1]);
  return second >= 0x80 && second <= 0x9F;
}

}  // namespace

std::string with_visible_controls(std::string_view text) {
  std::string visible;
  visible.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (is_single_byte_control(byte)) {
      visible += fmt::format("\\x{:02x}", byte);
    } else if (is_two_byte_control(text, i)) {
      visible += fmt::format("\\u{:04x}", static_cast<unsigned char>(text[++i]));
    } else {
      visible += text[i];
    }
  }
  return visible;
}

std::string counted(std::size_t count, std::string_view one, std::string_view many) {
  return std::to_string(count) + " " + std::string(count == 1 ? one : many);
}

}  // namespace silvafit
