// SPDX-License-Identifier: MIT
#include "silvafit/fit/formula_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "silvafit/base/error.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

/// Whether a part between bars is a condition, which || may join.
bool is_condition(std::string_view text, Part part) {
  return find_outside(text, part, "<>=!&") < part.end;
}

/// Reads a summand that is a bar term; false for others.
bool read_bar(std::string_view text, Part part, BarTerm& bar) {
  if (!is_enclosed(text, part)) return false;
  const Part inside{part.begin + 1, part.end - 1};
  const std::size_t place = find_outside(text, inside, "|");
  if (place == inside.end) return false;
  bar.is_uncorrelated = place + 1 < inside.end && text[place + 1] == '|';
  const Part left = trimmed(text, inside.begin, place);
  const Part right = trimmed(text, place + (bar.is_uncorrelated ? 2 : 1), inside.end);
  if (bar.is_uncorrelated && (is_condition(text, left) || is_condition(text, right))) return false;
  bar.text = of(text, part);
  bar.effects = of(text, left);
  bar.group = of(text, right);
  if (left.begin == left.end || right.begin == right.end) {
    throw FormulaError("a random effect has the form (1 | group)", text, place + 1);
  }
  return true;
}

/// h ~ a + b*dbh | plot
void refuse_bare_bar(std::string_view text, Part right) {
  const std::size_t place = find_outside(text, right, "|");
  const bool is_or = place + 1 < right.end && text[place + 1] == '|';
  if (place == right.end || is_or) return;
  throw FormulaError(
      "random effects are given by `random`, which names the coefficients that vary between the "
      "groups, such as `random=a | plot`",
      text,
      place + 1);
}

/// h ~ f ~ a | plot, as R's nlmer has it.
void refuse_second_tilde(std::string_view text, Part right) {
  const std::size_t place = find_outside(text, right, "~");
  if (place == right.end) return;
  const Part random = trimmed(text, place + 1, right.end);
  const bool has_bar = find_outside(text, random, "|") < random.end;
  throw FormulaError(fmt::format("a formula has one ~; random effects are given by `random={}`",
                                 has_bar ? of(text, random) : std::string_view("a | plot")),
                     text,
                     place + 1);
}

}  // namespace

std::vector<std::string> BarTerm::group_columns() const {
  std::vector<std::string> columns;
  for (const Part outer : split(group, 0, group.size(), '/')) {
    for (const Part part : split(group, outer.begin, outer.end, ':')) {
      columns.emplace_back(of(group, part));
    }
  }
  for (std::string& column : columns) std::erase(column, '`');
  return columns;
}

FormulaParts split_formula(std::string_view formula) {
  const std::size_t tilde = find_outside(formula, {0, formula.size()}, "~");
  if (tilde == formula.size()) return {.fixed = std::string(formula)};
  const Part right{tilde + 1, formula.size()};
  refuse_second_tilde(formula, right);
  refuse_bare_bar(formula, right);
  FormulaParts parts;
  std::string kept;
  for (const Part part : split(formula, right.begin, right.end, '+')) {
    BarTerm bar;
    if (read_bar(formula, part, bar)) {
      parts.bars.push_back(std::move(bar));
    } else {
      kept += (kept.empty() ? " " : " + ") + std::string(of(formula, part));
    }
  }
  // Without random effects the text stays as it is, so that positions in messages are right.
  if (parts.bars.empty()) return {.fixed = std::string(formula)};
  parts.fixed = std::string(formula.substr(0, tilde + 1)) + (kept.empty() ? " 1" : kept);
  return parts;
}

}  // namespace silvafit::fit
