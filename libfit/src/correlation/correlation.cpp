// SPDX-License-Identifier: MIT
#include "silvafit/fit/correlation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <iterator>

#include "silvafit/base/error.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

using Kind = Correlation::Kind;

constexpr std::array<std::string_view, 10> kNames{"ar1",
                                                  "car1",
                                                  "arma",
                                                  "compound-symmetry",
                                                  "symmetric",
                                                  "exponential",
                                                  "gaussian",
                                                  "spherical",
                                                  "rational-quadratic",
                                                  "linear"};

Kind parse_kind(std::string_view text, Part part) {
  const auto found = std::ranges::find(kNames, of(text, part));
  if (found == kNames.end()) {
    throw FormulaError(fmt::format("unknown correlation '{}'; available: none, {}",
                                   of(text, part),
                                   fmt::join(kNames, ", ")),
                       text,
                       part.begin + 1);
  }
  return static_cast<Kind>(found - kNames.begin());
}

/// Reads p and q from the first parts, which it removes.
void parse_orders(std::string_view text, std::vector<Part>& parts, Correlation& result) {
  for (int* const order : {&result.autoregressive, &result.moving_average}) {
    const std::string_view digits = parts.empty() ? "" : of(text, parts.front());
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), *order);
    constexpr int kHighest = 5;
    if (end.ec != std::errc() || end.ptr != digits.data() + digits.size() || *order < 0 ||
        *order > kHighest) {
      throw FormulaError(fmt::format("arma needs its two orders, 0 to {}: arma(1, 1)", kHighest),
                         text,
                         parts.empty() ? text.size() : parts.front().begin + 1);
    }
    parts.erase(parts.begin());
  }
  if (result.autoregressive + result.moving_average == 0) {
    throw FormulaError("one of the orders of arma has to be above 0", text, 1);
  }
}

bool is_spatial(Kind kind) { return kind >= Kind::kExponential; }

/// Checks the number of columns of a kind.
void require_columns(const Correlation& correlation, std::string_view text) {
  const std::size_t count = correlation.columns.size();
  const Kind kind = correlation.kind;
  const std::string_view name = kNames[static_cast<std::size_t>(kind)];
  if (kind == Kind::kCar1 && count != 1) {
    throw FormulaError("car1 needs one column with the time, for example car1(age)", text, 1);
  }
  if (is_spatial(kind) && count == 0) {
    throw FormulaError(
        fmt::format("{0} needs the columns of the coordinates, for example {0}(x, y)", name),
        text,
        1);
  }
  if (kind == Kind::kCompoundSymmetry && count != 0) {
    throw FormulaError(
        "compound-symmetry has no time; groups are given as in compound-symmetry(1 | plot)",
        text,
        1);
  }
  if (!is_spatial(kind) && count > 1) {
    throw FormulaError(
        fmt::format("{} has one column with the time, not {}", name, count), text, 1);
  }
}

void require_different(const std::vector<std::string>& columns, std::string_view text) {
  for (std::size_t k = 1; k < columns.size(); ++k) {
    if (std::ranges::count(columns, columns[k]) < 2) continue;
    throw FormulaError(
        fmt::format("{} is given twice; a distance has each coordinate once", columns[k]), text, 1);
  }
}

/// Reads `x, y | plot` and, after a semicolon at the end of either side, `nugget`.
void parse_arguments(std::string_view text, Part whole, Correlation& result) {
  std::vector<Part> sides = split(text, whole.begin, whole.end, '|');
  if (sides.size() > 2) throw FormulaError("there is one grouping", text, sides[2].begin + 1);
  for (Part& side : sides) {
    const std::vector<Part> halves = split(text, side.begin, side.end, ';');
    side = halves.front();
    if (halves.size() < 2) continue;
    const bool is_nugget = of(text, halves[1]) == "nugget" && is_spatial(result.kind);
    if (!is_nugget || result.has_nugget || halves.size() > 2) {
      throw FormulaError("only a nugget of structures by distance can stand after the semicolon",
                         text,
                         halves[1].begin + 1);
    }
    result.has_nugget = true;
  }
  if (sides.size() > 1) {
    result.group = column_name(text, sides[1]);
    if (result.group.empty()) throw FormulaError("expected a column", text, sides[1].begin + 1);
  }
  std::vector<Part> parts;
  if (sides[0].begin < sides[0].end) parts = split(text, sides[0].begin, sides[0].end, ',');
  if (result.kind == Kind::kArma) parse_orders(text, parts, result);
  // "1" is the order of the rows, as in nlme's formulas.
  if (parts.size() == 1 && of(text, parts[0]) == "1") parts.clear();
  for (const Part part : parts) {
    if (part.begin == part.end) throw FormulaError("expected a column", text, part.begin + 1);
    result.columns.push_back(column_name(text, part));
  }
}

}  // namespace

Correlation parse_correlation(std::string_view text) {
  const Part whole = trimmed(text, 0, text.size());
  const std::size_t parenthesis = std::min(text.find('('), whole.end);
  Correlation result{.kind = parse_kind(text, trimmed(text, whole.begin, parenthesis))};
  if (parenthesis < whole.end) {
    if (text[whole.end - 1] != ')') throw FormulaError("expected )", text, whole.end);
    parse_arguments(text, trimmed(text, parenthesis + 1, whole.end - 1), result);
  } else if (result.kind == Kind::kArma) {
    throw FormulaError("arma needs its two orders: arma(1, 1)", text, whole.end);
  }
  require_columns(result, text);
  require_different(result.columns, text);
  return result;
}

std::string Correlation::text() const {
  std::vector<std::string> parts;
  if (kind == Kind::kArma) {
    parts = {std::to_string(autoregressive), std::to_string(moving_average)};
  }
  std::ranges::transform(columns, std::back_inserter(parts), column_text);
  if (columns.empty() && !group.empty()) parts.emplace_back("1");
  std::string arguments = fmt::format("{}", fmt::join(parts, ", "));
  if (!group.empty()) arguments += " | " + column_text(group);
  if (has_nugget) arguments += "; nugget";
  const std::string name(kNames[static_cast<std::size_t>(kind)]);
  return arguments.empty() ? name : fmt::format("{}({})", name, arguments);
}

}  // namespace silvafit::fit
