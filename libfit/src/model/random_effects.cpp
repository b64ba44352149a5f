// SPDX-License-Identifier: MIT
#include "silvafit/fit/random_effects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <utility>

#include "silvafit/base/error.hpp"
#include "text/text_parts.hpp"

namespace silvafit::fit {
namespace {

void add_coefficient(std::string_view text, Part part, RandomEffects& random) {
  if (part.begin == part.end) {
    throw FormulaError("expected a coefficient", text, part.begin + 1);
  }
  random.coefficients.emplace_back(of(text, part));
}

/// Adds `a`, or the block `(a + b)`.
void add_block(std::string_view text, Part part, RandomEffects& random) {
  const std::size_t before = random.coefficients.size();
  const std::string_view term = of(text, part);
  if (term.starts_with('(') && term.ends_with(')')) {
    random.covariance = Covariance::kBlock;
    for (const Part inside : split(text, part.begin + 1, part.end - 1, '+')) {
      add_coefficient(text, inside, random);
    }
  } else {
    add_coefficient(text, part, random);
  }
  random.blocks.push_back(static_cast<int>(random.coefficients.size() - before));
}

/// The effects of `a + b ~ 1 | plot`, as nlme writes them.
Part without_constant(std::string_view text, Part effects) {
  const std::size_t tilde = find_outside(text, effects, "~");
  if (tilde == effects.end) return effects;
  if (of(text, trimmed(text, tilde + 1, effects.end)) != "1") {
    throw FormulaError(
        "random effects of covariates are written a + a:C | plot, with the sub-model a ~ 1 + C",
        text,
        tilde + 1);
  }
  return {effects.begin, tilde};
}

/// Adds the terms of `stand/plot`; `recipe:replicate` is one term. Coarser groups that have a term
/// of their own already, as in `a | stand; a + b | stand/plot`, are not added again.
/// \param adds  whether all terms are added, as in the sum `(a | stand) + (b | stand/plot)`
void add_levels(std::string_view text,
                Part whole,
                RandomEffects random,
                bool adds,
                std::vector<RandomEffects>& terms) {
  const std::vector<Part> levels = split(text, whole.begin, whole.end, '/');
  for (const Part level : levels) {
    for (const Part column : split(text, level.begin, level.end, ':')) {
      if (column.begin == column.end) {
        throw FormulaError("expected a group column", text, whole.begin + 1);
      }
      if (!random.group.empty()) random.within.push_back(random.group);
      random.group = column_name(text, column);
      if (std::ranges::find(random.within, random.group) != random.within.end()) {
        throw FormulaError("nested groupings need two different columns", text, column.begin + 1);
      }
    }
    const bool is_known = std::ranges::any_of(
        terms, [&](const RandomEffects& term) { return term.has_groups_of(random); });
    const bool is_finest = level.end == levels.back().end;
    if (is_known && (is_finest || adds)) {
      throw FormulaError(
          fmt::format("the groups of {} are given twice; independent effects of one grouping are "
                      "written as blocks, as in `(a) + b | plot`",
                      random.group),
          text,
          level.begin + 1);
    }
    if (!is_known) terms.push_back(random);
  }
}

/// Reads `a + b | plot`, `a + b | stand/plot`, or with crossed groups `a + b | plot + year`.
void add_grouping(std::string_view text, Part whole, bool adds, std::vector<RandomEffects>& terms) {
  const std::size_t bar = find_outside(text, whole, "|");
  if (bar == whole.end) {
    throw FormulaError(
        "random effects have the form `a + b:C | group`; the | is missing", text, whole.end + 1);
  }
  RandomEffects random;
  const Part effects = without_constant(text, {whole.begin, bar});
  for (const Part part : split(text, effects.begin, effects.end, '+')) {
    add_block(text, part, random);
  }
  if (random.covariance != Covariance::kBlock) random.blocks.clear();
  const std::vector<Part> groups = split(text, bar + 1, whole.end, '+');
  random.is_crossed = groups.size() > 1;
  for (const Part group : groups) {
    if (group.begin == group.end) throw FormulaError("expected a group column", text, bar + 2);
    add_levels(text, group, random, adds, terms);
  }
}

/// Reads one grouping, also in parentheses, or the sum of several, `(a | plot) + (b | year)`.
void add_terms(std::string_view text, Part part, std::vector<RandomEffects>& terms) {
  const auto without_parentheses = [text](Part whole) {
    return is_enclosed(text, whole) ? trimmed(text, whole.begin + 1, whole.end - 1) : whole;
  };
  const std::vector<Part> bars = split(text, part.begin, part.end, '+');
  const bool are_several =
      bars.size() > 1 && std::ranges::all_of(bars, [text](Part bar) {
        return is_enclosed(text, bar) && of(text, bar).find('|') != std::string_view::npos;
      });
  if (!are_several) return add_grouping(text, without_parentheses(part), false, terms);
  for (const Part bar : bars) {
    add_grouping(text, without_parentheses(bar), true, terms);
    terms.back().is_crossed = true;
  }
}

/// Whether terms are one grouping, or two that may be nested.
bool are_nested(const std::vector<RandomEffects>& terms) {
  if (terms.size() > 2 || !terms.front().within.empty()) return false;
  const std::vector<std::string>& within = terms.back().within;
  return within.empty() || within == std::vector{terms.front().group};
}

}  // namespace

std::vector<int> RandomEffects::block_sizes() const {
  const auto size = static_cast<int>(coefficients.size());
  if (size == 0) return {};
  if (covariance == Covariance::kBlock) return blocks;
  const bool is_joint =
      covariance == Covariance::kGeneral || covariance == Covariance::kCompoundSymmetry;
  if (is_joint) return {size};
  return std::vector<int>(coefficients.size(), 1);
}

std::string RandomEffects::text() const {
  if (covariance != Covariance::kBlock) return fmt::format("{}", fmt::join(coefficients, " + "));
  std::vector<std::string> terms;
  auto first = coefficients.begin();
  for (const int size : blocks) {
    const std::string term = fmt::format("{}", fmt::join(first, first + size, " + "));
    // Parentheses around the first block alone would be read as blocks of one for the others.
    terms.push_back(size > 1 || terms.empty() ? "(" + term + ")" : term);
    first += size;
  }
  return fmt::format("{}", fmt::join(terms, " + "));
}

std::string RandomEffects::group_text() const {
  std::string text;
  for (const std::string& column : within) text += column + (is_crossed ? ":" : "/");
  return text + group;
}

bool are_crossed(const std::vector<RandomEffects>& terms) {
  return std::ranges::any_of(terms, &RandomEffects::is_crossed);
}

std::vector<RandomEffects> parse_random_effects(std::string_view text) {
  std::vector<RandomEffects> terms;
  for (const Part part : split(text, 0, text.size(), ';')) add_terms(text, part, terms);
  if (are_crossed(terms) || !are_nested(terms)) {
    for (RandomEffects& term : terms) term.is_crossed = true;
  }
  return terms;
}

bool are_bars(std::string_view text) {
  const std::vector<Part> parts = split(text, 0, text.size(), ';');
  return std::ranges::all_of(parts, [text](Part part) { return is_enclosed(text, part); });
}

std::string outer_part(std::string_view outer) {
  std::string label;
  for (const char byte : outer) label += byte == '/' ? std::string("%2F") : std::string(1, byte);
  return label;
}

std::string without_escapes(std::string_view part) {
  std::string label(part);
  for (std::size_t at = 0; (at = label.find("%2F", at)) != std::string::npos; ++at) {
    label.replace(at, 3, "/");
  }
  return label;
}

std::string nested_label(std::string_view outer, std::string_view inner) {
  return outer_part(outer).append("/").append(inner);
}

std::string nested_label(const std::vector<std::string_view>& labels) {
  std::string result;
  for (std::size_t k = 0; k + 1 < labels.size(); ++k) result += outer_part(labels[k]) + "/";
  return result.append(labels.back());
}

NestedParts nested_parts(std::string_view label) {
  const std::size_t slash = label.find('/');
  if (slash == std::string_view::npos) return {.inner = label};
  return {.outer = label.substr(0, slash), .inner = label.substr(slash + 1)};
}

Covariance parse_covariance(std::string_view text) {
  const std::optional<Covariance> found = find_word<Covariance>(text);
  if (found && *found != Covariance::kBlock) return *found;
  throw UsageError(
      fmt::format("unknown covariance structure '{}'; available: general, diagonal, identity, "
                  "compound-symmetry, and blocks by parentheses as in `random=(a + b) + c | plot`",
                  text));
}

}  // namespace silvafit::fit
