// SPDX-License-Identifier: MIT
// Single fields of CSV: missing values, numbers, quotes.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string>

#include "silvafit/data/csv.hpp"
#include "table/formula_guards.hpp"

namespace silvafit::data {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

/// Whether a byte is neither a blank nor a part of one.
bool is_plain(char c) { return c > ' ' && static_cast<unsigned char>(c) < 0x80; }

bool is_letter_or_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// Blanks beyond ASCII from spreadsheets and web pages: no-break and ideographic space.
constexpr std::array<std::string_view, 2> kWideBlanks{"\xC2\xA0", "\xE3\x80\x80"};

/// Texts for a value that was not measured, in capitals or not, and the errors of spreadsheets.
constexpr std::array<std::string_view, 44> kMissingTexts{
    "-",      "--",    "---",   "\u2013",  "\u2014", ".",       "..",       "?",     "??",
    "na",     "n/a",   "n.a.",  "n.a",     "#n/a",   "#na",     "#nv",      "#nd",   "#value!",
    "#wert!", "#ref!", "#num!", "#bezug!", "#zahl!", "#div/0!", "#valeur!", "nan",   "null",
    "nil",    "none",  "nd",    "n.d.",    "n.d",    "n.b.",    "nb",       "k.a.",  "k. a.",
    "k.a",    "ka",    "s/d",   "missing", "*",      "/",       "\u65e0",   "\u7f3a"};

/// Whether a spreadsheet may read a text as a formula, with or without blanks and apostrophes
/// before it.
bool begins_formula(std::string_view text) {
  if (!text.empty() && is_letter_or_digit(text.front())) return false;
  const std::size_t first = text.find_first_not_of("' \t\r\n");
  return first != std::string_view::npos &&
         std::string_view("=+-@").find(text[first]) != std::string_view::npos;
}

/// What ends cells or lines where a spreadsheet takes another separator than the comma.
constexpr char kCellEnds[] = ";\t\r\n";

/// Numbers and codes of missing values are no formulas.
bool is_harmless(std::string_view part) {
  double ignored = 0.0;
  return is_missing_number(part) || parse_number(part, ignored) ||
         !with_decimal_point(part).empty();
}

/// Puts an apostrophe before each part of a text that needs one.
template <typename Needs>
std::string guarded(std::string_view text, const Needs& needs) {
  std::string result;
  for (;;) {
    const std::size_t end = std::min(text.find_first_of(kCellEnds), text.size());
    if (needs(text.substr(0, end))) result += '\'';
    result += text.substr(0, std::min(end + 1, text.size()));
    if (end == text.size()) return result;
    text.remove_prefix(end + 1);
  }
}

bool has_guard(std::string_view part) { return part.starts_with('\'') && begins_formula(part); }

}  // namespace

std::string_view trimmed(std::string_view field) {
  // Nearly all fields of large files.
  if (!field.empty() && is_plain(field.front()) && is_plain(field.back())) return field;
  for (std::size_t before = std::string_view::npos; before != field.size();) {
    before = field.size();
    while (!field.empty() && is_blank(field.front())) field.remove_prefix(1);
    while (!field.empty() && is_blank(field.back())) field.remove_suffix(1);
    for (const std::string_view blank : kWideBlanks) {
      if (field.starts_with(blank)) field.remove_prefix(blank.size());
      if (field.ends_with(blank)) field.remove_suffix(blank.size());
    }
  }
  return field;
}

bool is_missing_field(std::string_view field) {
  const std::string_view text = trimmed(field);
  return text.empty() || text == "NA";
}

bool is_missing_number(std::string_view field) {
  if (is_missing_field(field)) return true;
  constexpr std::size_t kLongest = 8;
  std::string text(trimmed(field));
  if (text.size() > kLongest) return false;
  std::ranges::transform(
      text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::ranges::find(kMissingTexts, text) != kMissingTexts.end();
}

bool parse_number(std::string_view field, double& value) {
  std::string_view text = trimmed(field);
  // from_chars does not accept a plus sign; a second sign after it is an error.
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double parsed = 0.0;
  const char* const last = text.data() + text.size();
  const auto [end, status] = std::from_chars(text.data(), last, parsed);
  if (end != last || status == std::errc::invalid_argument) return false;
  // A number out of range is a number: infinite, or too small to differ from zero.
  if (status == std::errc::result_out_of_range) {
    parsed = std::strtod(std::string(text).c_str(), nullptr);
  }
  value = parsed;
  return true;
}

std::string with_decimal_point(std::string_view field) {
  constexpr std::string_view kOfNumbers = "0123456789,eE+- \t";
  const std::size_t comma = field.find(',');
  if (comma == std::string_view::npos || field.find(',', comma + 1) != std::string_view::npos) {
    return {};
  }
  if (field.find_first_not_of(kOfNumbers) != std::string_view::npos) return {};
  std::string text(field);
  text[comma] = '.';
  double ignored = 0.0;
  return parse_number(text, ignored) ? text : std::string();
}

std::string plain_csv_field(std::string_view text) {
  if (text.find_first_of(",;\"\t\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_field(std::string_view text) {
  if (text.find_first_of(kCellEnds) == std::string_view::npos && !begins_formula(text)) {
    return plain_csv_field(text);
  }
  return plain_csv_field(with_guards(text));
}

std::string with_guards(std::string_view text) {
  return guarded(text,
                 [](std::string_view part) { return begins_formula(part) && !is_harmless(part); });
}

std::string with_kept_apostrophes(std::string_view text) { return guarded(text, has_guard); }

std::size_t remove_guards(char* text, std::size_t length) {
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < length;) {
    const std::string_view rest(text + begin, length - begin);
    const std::size_t end = std::min(rest.find_first_of(kCellEnds), rest.size() - 1) + 1;
    const std::size_t first = has_guard(rest.substr(0, rest.find_first_of(kCellEnds))) ? 1 : 0;
    if (kept != begin + first) std::memmove(text + kept, text + begin + first, end - first);
    kept += end - first;
    begin += end;
  }
  return kept;
}

}  // namespace silvafit::data
