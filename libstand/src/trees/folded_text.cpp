// SPDX-License-Identifier: MIT
#include "trees/folded_text.hpp"

#include <cctype>

#include "silvafit/data/csv.hpp"

namespace silvafit::stand {

std::string folded_letters(std::string_view text) {
  std::string out = folded(text);
  // Signs of Latin-1, such as the degree of N°, come as 0xC2 and a byte.
  for (std::size_t at = out.find('\xC2'); at != std::string::npos; at = out.find('\xC2', at)) {
    out.erase(at, 2);
  }
  std::erase_if(out, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x80 && std::isalnum(byte) == 0;
  });
  return out;
}

bool is_same_code(std::string_view left, std::string_view right) {
  double left_number = 0.0;
  double right_number = 0.0;
  const bool are_numbers =
      data::parse_number(left, left_number) && data::parse_number(right, right_number);
  if (are_numbers) return left_number == right_number;
  return folded(data::trimmed(left)) == folded(data::trimmed(right));
}

}  // namespace silvafit::stand
