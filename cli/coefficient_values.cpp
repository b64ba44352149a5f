// SPDX-License-Identifier: MIT
#include "coefficient_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::cli {
namespace {

/// End of the part that begins at a position: a comma outside parentheses and quotes, because names
/// of coefficients may contain both: a:min(x, 20), a:(species == "oak, red").
std::size_t end_of_part(std::string_view text, std::size_t begin) {
  int depth = 0;
  char quote = '\0';
  for (std::size_t i = begin; i < text.size(); ++i) {
    const char byte = text[i];
    if (quote != '\0') {
      if (byte == quote) quote = '\0';
      continue;
    }
    if (byte == '"' || byte == '\'' || byte == '`') quote = byte;
    if (byte == ',' && depth == 0) return i;
    depth += static_cast<int>(byte == '(') - static_cast<int>(byte == ')');
  }
  return text.size();
}

/// The texts of `name=text,...` by name.
std::map<std::string, std::string_view> parse_assignments(std::string_view text,
                                                          const std::string& option,
                                                          const std::string& form) {
  std::map<std::string, std::string_view> result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = end_of_part(text, begin);
    const std::string_view part = text.substr(begin, end - begin);
    // The name of a coefficient may contain a comparison: b:species == "SM".
    const std::size_t sign = part.rfind('=');
    if (sign == std::string_view::npos) {
      throw UsageError(fmt::format("'{}' is not {}", part, form), {.column = option});
    }
    result[std::string(data::trimmed(part.substr(0, sign)))] = data::trimmed(part.substr(sign + 1));
    begin = end + 1;
  }
  return result;
}

double parse_value(std::string_view text, const std::string& option) {
  double value = 0.0;
  if (data::parse_number(text, value)) return value;
  throw UsageError(fmt::format("'{}' is not a number", text), {.column = option});
}

}  // namespace

std::map<std::string, double> parse_values(const std::string& text,
                                           const std::string& option,
                                           const std::string& form) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : parse_assignments(text, option, form)) {
    values[name] = parse_value(value, option);
  }
  return values;
}

std::map<std::string, fit::Bounds> parse_bounds(const std::string& text) {
  const std::string option = "--bound";
  std::map<std::string, fit::Bounds> bounds;
  for (const auto& [name, range] : parse_assignments(text, option, "NAME=LOW:HIGH")) {
    const std::size_t colon = range.find(':');
    if (colon == std::string_view::npos) {
      throw UsageError(fmt::format("'{}' is not a range such as 0:1, 0: or :1", range),
                       {.column = option});
    }
    const std::string_view low = data::trimmed(range.substr(0, colon));
    const std::string_view high = data::trimmed(range.substr(colon + 1));
    if (!low.empty()) bounds[name].low = parse_value(low, option);
    if (!high.empty()) bounds[name].high = parse_value(high, option);
  }
  return bounds;
}

}  // namespace silvafit::cli
