// SPDX-License-Identifier: MIT
#include "report/script_text.hpp"

#include <cstddef>

namespace silvafit::study {
namespace {

/// U+2028 and U+2029, which scripts read as line ends, share their first two bytes of UTF-8.
constexpr std::string_view kSeparatorLead = "\xE2\x80";

/// The escape of the character at the position, and how many bytes it replaces; empty if none is
/// needed.
struct Escape {
  std::string_view text{};
  std::size_t replaced = 1;
};

Escape escape_at(std::string_view json, std::size_t position) {
  switch (json[position]) {
    case '<':
      return {"\\u003c"};
    case '>':
      return {"\\u003e"};
    case '&':
      return {"\\u0026"};
    case '\xE2':
      break;
    default:
      return {};
  }
  const std::string_view sign = json.substr(position, 3);
  if (sign.size() < 3 || !sign.starts_with(kSeparatorLead)) return {};
  if (sign[2] == '\xA8') return {"\\u2028", 3};
  if (sign[2] == '\xA9') return {"\\u2029", 3};
  return {};
}

}  // namespace

std::string escape_for_script(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size() + json.size() / 64);
  for (std::size_t position = 0; position < json.size();) {
    const Escape escape = escape_at(json, position);
    if (escape.text.empty()) {
      escaped += json[position];
    } else {
      escaped += escape.text;
    }
    position += escape.replaced;
  }
  return escaped;
}

}  // namespace silvafit::study
