// SPDX-License-Identifier: MIT
#include "workflow/recurring_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "silvafit/base/text.hpp"
#include "silvafit/fit/random_effects.hpp"
#include "silvafit/stand/unread_columns.hpp"

namespace silvafit::study {
namespace {

using Names = std::vector<std::string>;

bool contains_group(const Names& groups, const std::string& name) {
  return std::ranges::find(groups, name) != groups.end();
}

/// Labels of a term's groups that occur in several places, by their code. A term `site/plot` has
/// other groups of the same label in each site.
std::set<std::uint32_t> recurring_labels(const fit::RandomEffects& term,
                                         const data::Table& table,
                                         const data::TextColumn& places) {
  std::vector<data::TextColumn> columns;
  for (const std::string& name : term.within) columns.push_back(table.labels(name));
  columns.push_back(table.labels(term.group));
  std::map<std::vector<std::uint32_t>, std::uint32_t> first_place;
  std::set<std::uint32_t> recurring;
  for (std::size_t row = 0; row < places.size(); ++row) {
    const auto is_missing = [row](const data::TextColumn& one) { return one.is_missing(row); };
    if (places.is_missing(row) || std::ranges::any_of(columns, is_missing)) continue;
    std::vector<std::uint32_t> group;
    for (const data::TextColumn& one : columns) group.push_back(one.code(row));
    const auto known = first_place.try_emplace(group, places.code(row)).first;
    if (known->second != places.code(row)) recurring.insert(group.back());
  }
  return recurring;
}

}  // namespace

std::vector<std::string> describe_recurring_groups(const data::Table& table,
                                                   const Names& header,
                                                   const std::vector<stand::ColumnMapping>& mapped,
                                                   const std::string& random) {
  const std::vector<fit::RandomEffects> terms = fit::parse_random_effects(random);
  Names grouped;
  for (const fit::RandomEffects& term : terms) grouped.push_back(term.group);
  const auto column_of = [&](const std::string& name) -> std::string {
    const auto fields = stand::fields_of(name, header, mapped, table.file());
    return fields.size() == 1 ? header[fields.front()] : std::string();
  };
  std::vector<std::pair<std::string, std::string>> levels{{"tree", column_of("plot")}};
  for (const std::size_t field : stand::fields_of_units(header)) {
    levels.emplace_back("plot", header[field]);
  }
  Names notes;
  for (const auto& [inner, within] : levels) {
    const std::string group = column_of(inner);
    const bool is_alone = !within.empty() && within != group && contains_group(grouped, group) &&
                          !contains_group(grouped, within) && table.has(group) && table.has(within);
    if (!is_alone) continue;
    const auto& term = *std::ranges::find(terms, group, &fit::RandomEffects::group);
    const auto has_column = [&table](const std::string& name) { return table.has(name); };
    if (!std::ranges::all_of(term.within, has_column)) continue;
    const std::set<std::uint32_t> recurring = recurring_labels(term, table, table.labels(within));
    if (recurring.empty()) continue;
    const data::TextColumn labels = table.labels(group);
    notes.push_back(fmt::format(
        "{} of the column {} {} in several values of {} ({}): each is one group here; if "
        "it is another {} in each of them, group by `{}/{}`",
        counted(recurring.size(), "label", "labels"),
        group,
        recurring.size() == 1 ? "occurs" : "occur",
        within,
        labels.levels()[*recurring.begin()],
        inner,
        within,
        group));
  }
  return notes;
}

}  // namespace silvafit::study
