// SPDX-License-Identifier: MIT
// Single fields of CSV: what is missing, what is a number, what needs quotes.
#include <charconv>
#include <cstdlib>
#include <string>

#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t'; }

}  // namespace

std::string_view trimmed(std::string_view field) {
  while (!field.empty() && is_blank(field.front())) field.remove_prefix(1);
  while (!field.empty() && is_blank(field.back())) field.remove_suffix(1);
  return field;
}

bool is_missing_field(std::string_view field) {
  const std::string_view text = trimmed(field);
  return text.empty() || text == "NA";
}

bool parse_number(std::string_view field, double& value) {
  std::string_view text = trimmed(field);
  // from_chars knows no plus sign; what follows it must not be a second sign.
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double parsed = 0.0;
  const char* const last = text.data() + text.size();
  const auto [end, status] = std::from_chars(text.data(), last, parsed);
  if (end != last || status == std::errc::invalid_argument) return false;
  // Out of range is a number all the same: infinite, or too small to differ from zero.
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

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace silvafit::data
