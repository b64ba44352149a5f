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

/// Reads `a + b | plot` or `a + b | stand/plot`.
std::vector<RandomEffects> parse_grouping(std::string_view text, Part whole) {
  // As lme4 writes it, (a | plot).
  if (is_enclosed(text, whole)) whole = trimmed(text, whole.begin + 1, whole.end - 1);
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
  std::vector<RandomEffects> groupings;
  for (const Part group : split(text, bar + 1, whole.end, '/')) {
    if (group.begin == group.end) throw FormulaError("expected a group column", text, bar + 2);
    random.within = std::exchange(random.group, of(text, group));
    groupings.push_back(random);
  }
  return groupings;
}

}  // namespace

std::vector<int> RandomEffects::block_sizes() const {
  const auto size = static_cast<int>(coefficients.size());
  if (size == 0) return {};
  if (covariance == Covariance::kBlock) return blocks;
  if (covariance == Covariance::kGeneral) return {size};
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
  return within.empty() ? group : within + "/" + group;
}

std::vector<RandomEffects> parse_random_effects(std::string_view text) {
  std::vector<RandomEffects> groupings;
  std::size_t end = 0;
  for (const Part part : split(text, 0, text.size(), ';')) {
    std::vector<RandomEffects> terms = parse_grouping(text, part);
    // In `a | stand; a + b | stand/plot` the stands have a term of their own.
    const bool has_own = groupings.size() == 1 && terms.size() == 2 &&
                         groupings.front().group == terms.front().group;
    if (has_own) terms.erase(terms.begin());
    std::ranges::move(terms, std::back_inserter(groupings));
    end = part.end;
    if (groupings.size() > 2) {
      throw FormulaError("at most two nested groupings can be fitted", text, part.begin + 1);
    }
  }
  if (groupings.size() == 2 && groupings[0].group == groupings[1].group) {
    throw FormulaError("nested groupings need two different columns", text, end);
  }
  return groupings;
}

std::string outer_part(std::string_view outer) {
  std::string label;
  for (const char byte : outer) label += byte == '/' ? std::string("%2F") : std::string(1, byte);
  return label;
}

std::string nested_label(std::string_view outer, std::string_view inner) {
  return outer_part(outer).append("/").append(inner);
}

NestedParts nested_parts(std::string_view label) {
  const std::size_t slash = label.find('/');
  if (slash == std::string_view::npos) return {.inner = label};
  return {.outer = label.substr(0, slash), .inner = label.substr(slash + 1)};
}

Covariance parse_covariance(std::string_view text) {
  if (text == "general") return Covariance::kGeneral;
  if (text == "diagonal") return Covariance::kDiagonal;
  if (text == "identity") return Covariance::kIdentity;
  throw UsageError(
      fmt::format("unknown covariance structure '{}'; available: general, diagonal, identity, and "
                  "blocks by parentheses as in `random=(a + b) + c | plot`",
                  text));
}

std::string covariance_text(Covariance covariance) {
  constexpr std::array kNames{"general", "diagonal", "identity", "block"};
  return kNames[static_cast<std::size_t>(covariance)];
}

}  // namespace silvafit::fit
