// SPDX-License-Identifier: MIT
#include "silvafit/stand/species_spellings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "silvafit/base/text.hpp"
#include "trees/folded_text.hpp"

namespace silvafit::stand {
namespace {

/// A name in lower case, with single blanks.
std::string key_of(const std::string& name) {
  std::string key = folded(name);
  const auto both_blank = [](char left, char right) { return left == ' ' && right == ' '; };
  key.erase(std::unique(key.begin(), key.end(), both_blank), key.end());
  return key;
}

std::vector<std::size_t> tree_counts(const data::TextColumn& column) {
  std::vector<std::size_t> counts(column.levels().size(), 0);
  for (std::size_t row = 0; row < column.size(); ++row) {
    if (!column.is_missing(row)) ++counts[column.code(row)];
  }
  return counts;
}

}  // namespace

void SpeciesSpellings::know(const std::vector<std::string>& species) {
  for (const std::string& name : species) {
    const auto [known, is_new] = spelling_of_.try_emplace(key_of(name), name);
    are_distinct_ = are_distinct_ || known->second != name;
  }
}

void SpeciesSpellings::unify(data::TextColumn& species) {
  if (are_distinct_) return;
  const std::vector<std::string>& levels = species.levels();
  const std::vector<std::size_t> counts = tree_counts(species);
  std::vector<std::string> keys;
  std::map<std::string, std::size_t> commonest;
  for (std::size_t code = 0; code < levels.size(); ++code) {
    keys.push_back(key_of(levels[code]));
    const auto [best, is_new] = commonest.try_emplace(keys.back(), code);
    if (!is_new && counts[code] > counts[best->second]) best->second = code;
  }
  for (const auto& [key, code] : commonest) spelling_of_.try_emplace(key, levels[code]);

  std::vector<std::string> spelling;
  bool is_changed = false;
  for (std::size_t code = 0; code < levels.size(); ++code) {
    spelling.push_back(spelling_of_.at(keys[code]));
    if (spelling.back() == levels[code] || counts[code] == 0) continue;
    is_changed = true;
    Change& change = changes_[levels[code]];
    change.to = spelling.back();
    change.trees += counts[code];
  }
  if (!is_changed) return;
  data::TextColumn unified;
  unified.reserve(species.size());
  for (std::size_t row = 0; row < species.size(); ++row) {
    species.is_missing(row) ? unified.append_missing()
                            : unified.append(spelling[species.code(row)]);
  }
  species = std::move(unified);
}

std::string SpeciesSpellings::note() const {
  constexpr std::size_t kShown = 5;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [from, change] : changes_) {
    if (shown++ == kShown) {
      text += fmt::format(" and {} more", changes_.size() - kShown);
      break;
    }
    text += fmt::format("{}'{}' as '{}' ({})",
                        text.empty() ? "" : ", ",
                        from,
                        change.to,
                        counted(change.trees, "tree", "trees"));
  }
  return text.empty()
             ? text
             : "species that differ only in capitals or spaces are treated as one: " + text +
                   "; `case_sensitive` keeps them separate";
}

}  // namespace silvafit::stand
