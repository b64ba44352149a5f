// SPDX-License-Identifier: MIT
#include "view/base64.hpp"

#include <cstdint>

namespace silvafit::study {

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U;
  };
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t three = byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2);
    for (std::size_t k = 0; k < 4; ++k) {
      // A last group of one or two bytes has only two or three digits.
      const bool has_content = i + k <= bytes.size();
      text += has_content ? kDigits[three >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace silvafit::study
