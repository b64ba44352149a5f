// SPDX-License-Identifier: MIT
#include "lsystem/lsystem_reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace silvafit::tree {
namespace {

/// Symbols and numbers of parameters in the axiom and successors, and the first line with them.
using Uses = std::map<std::pair<std::uint32_t, std::size_t>, std::size_t>;

void note(const std::vector<SuccessorModule>& word, std::size_t line, Uses& uses) {
  for (const SuccessorModule& module : word) {
    const auto [use, is_new] = uses.try_emplace({module.symbol, module.parameters.size()}, line);
    if (!is_new) use->second = std::min(use->second, line);
  }
}

Uses uses_of(const GrammarRules& rules) {
  Uses uses;
  note(rules.axiom, rules.axiom_line, uses);
  for (const Production& production : rules.productions) {
    note(production.successor, production.line, uses);
  }
  return uses;
}

/// The reason why no module has the production's symbol and number of parameters. Empty if none has
/// the symbol at all: grammars may contain unused productions.
std::string why_unmet(const GrammarRules& rules, const Uses& uses, const Production& production) {
  const auto count = production.parameter_count;
  const auto other = uses.lower_bound({production.symbol, 0});
  if (other == uses.end() || other->first.first != production.symbol) return {};
  return fmt::format("{} has {} parameter{} here, but {} in line {}; this production never applies",
                     (*rules.alphabet)[production.symbol],
                     count,
                     count == 1 ? "" : "s",
                     other->first.second,
                     other->second);
}

/// Empty if no earlier production matches all of this one's modules.
std::string why_preceded(const GrammarRules& rules, std::size_t index) {
  const Production& production = rules.productions[index];
  for (std::size_t before = 0; before < index; ++before) {
    const Production& earlier = rules.productions[before];
    const bool always = !earlier.condition && earlier.symbol == production.symbol &&
                        earlier.parameter_count == production.parameter_count;
    if (!always || (earlier.weight && production.weight)) continue;
    if (!earlier.weight && !production.weight) {
      return fmt::format("this production never applies: line {} comes first and has no condition",
                         earlier.line);
    }
    return fmt::format(
        "of this production and that of line {1}, which rewrite {0}, only one has a weight; give "
        "both a weight, or conditions that exclude each other",
        (*rules.alphabet)[production.symbol],
        earlier.line);
  }
  return {};
}

}  // namespace

std::vector<UnreachedProduction> unreached_productions(const GrammarRules& rules) {
  const Uses uses = uses_of(rules);
  std::vector<UnreachedProduction> unreached;
  for (std::size_t i = 0; i < rules.productions.size(); ++i) {
    const Production& production = rules.productions[i];
    const bool is_met = uses.contains({production.symbol, production.parameter_count});
    std::string why = is_met ? why_preceded(rules, i) : why_unmet(rules, uses, production);
    if (!why.empty()) unreached.push_back({i, std::move(why)});
  }
  return unreached;
}

}  // namespace silvafit::tree
