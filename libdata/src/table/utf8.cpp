// SPDX-License-Identifier: MIT
#include "table/utf8.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace silvafit::data {

namespace {

/// Offset of the first byte above 127 at or after `from`, or the length.
std::size_t skip_ascii(std::string_view text, std::size_t from) {
  constexpr std::uint64_t kHighBits = 0x8080808080808080U;
  std::size_t i = from;
  for (; i + sizeof(std::uint64_t) <= text.size(); i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, text.data() + i, sizeof word);
    if ((word & kHighBits) != 0) break;
  }
  while (i < text.size() && static_cast<unsigned char>(text[i]) < 0x80) ++i;
  return i;
}

/// Length of the well-formed sequence at the start of a text that begins above 127; 0 if there is
/// none. The narrower ranges of the second byte exclude overlong forms, surrogates and code points
/// beyond U+10FFFF.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  std::size_t length = 0;
  unsigned low = 0x80;
  unsigned high = 0xbf;
  if (lead >= 0xc2 && lead <= 0xdf) {
    length = 2;
  } else if (lead >= 0xe0 && lead <= 0xef) {
    length = 3;
    if (lead == 0xe0) low = 0xa0;
    if (lead == 0xed) high = 0x9f;
  } else if (lead >= 0xf0 && lead <= 0xf4) {
    length = 4;
    if (lead == 0xf0) low = 0x90;
    if (lead == 0xf4) high = 0x8f;
  }
  if (length == 0 || text.size() < length || byte(1) < low || byte(1) > high) return 0;
  for (std::size_t i = 2; i < length; ++i) {
    if (byte(i) < 0x80 || byte(i) > 0xbf) return 0;
  }
  return length;
}

}  // namespace

std::size_t first_invalid_utf8(std::string_view text) {
  for (std::size_t i = skip_ascii(text, 0); i < text.size(); i = skip_ascii(text, i)) {
    const std::size_t length = sequence_length(text.substr(i));
    if (length == 0) return i;
    i += length;
  }
  return std::string_view::npos;
}

namespace {

bool is_letter(std::string_view bytes, std::size_t i) {
  return i < bytes.size() && std::isalpha(static_cast<unsigned char>(bytes[i])) != 0;
}

/// Whether a run of bytes above 127 can be Chinese characters, which mostly have two such bytes
/// each. Two accented letters within a word, as in "Groesse", are not.
bool can_be_chinese(std::string_view bytes, std::size_t begin, std::size_t end) {
  const bool is_in_word = begin > 0 && is_letter(bytes, begin - 1) && is_letter(bytes, end);
  return (end - begin) % 2 == 0 && !(end - begin == 2 && is_in_word);
}

/// Whether at least three quarters of the bytes above 127 can belong to Chinese characters.
bool looks_chinese(std::string_view bytes) {
  const auto is_high = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]) > 0x80; };
  std::size_t chinese = 0;
  std::size_t all = 0;
  for (std::size_t begin = 0; begin < bytes.size();) {
    std::size_t end = begin;
    while (end < bytes.size() && is_high(end)) ++end;
    all += end - begin;
    if (end > begin && can_be_chinese(bytes, begin, end)) chinese += end - begin;
    begin = end + 1;
  }
  return all > 0 && 4 * chinese >= 3 * all;
}

/// The command that converts a file, with its name quoted for the shell if necessary.
std::string command(std::string_view encoding, const std::string& file) {
  const std::size_t dot = file.rfind('.');
  const std::size_t slash = file.rfind('/');
  const bool has_ending = dot != std::string::npos && (slash == std::string::npos || dot > slash);
  const std::string converted =
      has_ending ? file.substr(0, dot) + "-utf8" + file.substr(dot) : file + "-utf8";
  const char* const quote = file.find_first_of(" '()&;") == std::string::npos ? "" : "\"";
  return fmt::format(
      "iconv -f {0} -t UTF-8 {1}{2}{1} > {1}{3}{1}", encoding, quote, file, converted);
}

std::string advice(std::string_view likely, std::string_view encoding, const std::string& file) {
  return fmt::format(
      "{}; save it as \"CSV UTF-8\", or convert it: {}", likely, command(encoding, file));
}

}  // namespace

std::string advice_on_encoding(std::string_view bytes, const std::string& file) {
  if (looks_chinese(bytes)) {
    return advice("the file is likely GB18030 (Chinese)", "GB18030", file);
  }
  // Windows-1252 has no characters for these.
  const std::size_t other = bytes.find_first_of("\x81\x8D\x8F\x90\x9D");
  if (other != std::string_view::npos) {
    return fmt::format(
        "the file is neither UTF-8 nor Windows-1252 (byte 0x{:02X}); save it as \"CSV UTF-8\" with "
        "the program that wrote it, or convert it from its encoding, such as MACINTOSH or "
        "SHIFT_JIS: {}",
        static_cast<unsigned char>(bytes[other]),
        command("ENCODING", file));
  }
  return advice("the file is likely Windows-1252 or Latin-1", "CP1252", file);
}

bool looks_like_utf16(std::string_view text) {
  std::array<std::size_t, 2> zeros{};
  for (std::size_t i = 0; i < text.size(); ++i) zeros[i % 2] += text[i] == '\0' ? 1 : 0;
  return std::ranges::max(zeros) > 1 && std::ranges::min(zeros) == 0;
}

std::string advice_on_utf16(std::string_view bytes, const std::string& file) {
  const bool has_mark = bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF");
  const bool is_big_endian = bytes.starts_with('\0');
  const char* const encoding = has_mark ? "UTF-16" : is_big_endian ? "UTF-16BE" : "UTF-16LE";
  return advice("the file is UTF-16", encoding, file);
}

}  // namespace silvafit::data
