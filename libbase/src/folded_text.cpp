// SPDX-License-Identifier: MIT
#include "silvafit/base/folded_text.hpp"

#include <array>
#include <cctype>
#include <cstddef>

namespace silvafit {
namespace {

/// The letters of U+00C0 to U+017F (Latin-1 Supplement, Latin Extended-A) without their accents, in
/// lower case; a blank for signs.
constexpr std::string_view kWithoutAccents =
    "aaaaaaaceeeeiiiidnooooo ouuuuytsaaaaaaaceeeeiiiidnooooo ouuuuyty"
    "aaaaaaccccccccddddeeeeeeeeeegggggggghhhhiiiiiiiiiiiijjkkklllllll"
    "lllnnnnnnnnnoooooooorrrrrrssssssssttttttuuuuuuuuuuuuwwyyyzzzzzzs";
constexpr unsigned kFirstAccented = 0xC0;
constexpr unsigned kLastAccented = 0x17F;
static_assert(kWithoutAccents.size() == kLastAccented - kFirstAccented + 1);

/// Combining accents, which some systems write after the letter: U+0300 to U+036F.
constexpr bool is_combining(unsigned code) { return code >= 0x300 && code <= 0x36F; }

/// ASCII as full-width forms, which Chinese and Japanese input methods write: U+FF01 to U+FF5E.
constexpr bool is_full_width(unsigned code) { return code >= 0xFF01 && code <= 0xFF5E; }

/// Bytes of the UTF-8 sequence that begins with a byte.
std::size_t sequence_length(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead < 0xE0) return 2;
  return lead < 0xF0 ? 3 : 4;
}

unsigned code_point(std::string_view sequence) {
  constexpr std::array<unsigned char, 5> kMask{0, 0x7F, 0x1F, 0x0F, 0x07};
  unsigned code = static_cast<unsigned char>(sequence[0]) & kMask[sequence.size()];
  for (std::size_t i = 1; i < sequence.size(); ++i) {
    code = (code << 6U) | (static_cast<unsigned char>(sequence[i]) & 0x3FU);
  }
  return code;
}

void append_folded(std::string_view sequence, std::string& out) {
  unsigned code = code_point(sequence);
  if (is_combining(code)) return;
  if (is_full_width(code)) code -= 0xFF01 - 0x21;
  if (code < 0x80) {
    out += static_cast<char>(std::tolower(static_cast<int>(code)));
  } else if (code == 0xA0 || code == 0x3000) {
    out += ' ';
  } else if (code >= kFirstAccented && code <= kLastAccented) {
    out += kWithoutAccents[code - kFirstAccented];
  } else {
    out += sequence;
  }
}

}  // namespace

std::string folded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = sequence_length(static_cast<unsigned char>(text[i]));
    append_folded(text.substr(i, length), out);
    i += length;
  }
  return out;
}

}  // namespace silvafit
