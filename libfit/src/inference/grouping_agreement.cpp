// SPDX-License-Identifier: MIT
#include "inference/grouping_agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

namespace silvafit::fit {
namespace {

using Labels = std::vector<std::string>;

/// The groups of one term of a fit.
struct Grouping {
  const Labels* labels = nullptr;
  /// The fit, if labels are unique only within the groups of the term before.
  const FittedModel* within = nullptr;

  /// "plot (5 groups)", "plot within stand (30 groups)".
  std::string text(const std::string& group) const {
    const std::string where =
        within == nullptr ? "" : " within " + within->specification.random.front().group;
    return fmt::format("{}{} ({} groups)", group, where, labels->size());
  }
};

Grouping grouping_of(const FittedModel& fit, const std::string& group) {
  for (std::size_t t = 0; t + 1 < fit.random.size(); ++t) {
    if (fit.specification.random[t].group == group) return {.labels = &fit.random[t].labels};
  }
  return {.labels = &fit.random.back().labels, .within = fit.random.size() > 1 ? &fit : nullptr};
}

/// Where a fit is crossed, labels of both are those of the whole path of columns.
Grouping crossed_grouping(const FittedModel& fit, const RandomEffects& of) {
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    if (fit.specification.random[t].has_groups_of(of)) return {.labels = &fit.random[t].labels};
  }
  return {.labels = &fit.random.back().labels};
}

bool have_same_labels(Labels a, Labels b) {
  std::ranges::sort(a);
  std::ranges::sort(b);
  return a == b;
}

/// Whether labels that are nested in coarser groups are unique without these: each nested group is
/// in a coarser one that the fit has, and each inner label belongs to one nested group.
bool are_unique_labels(const FittedModel& nested, const Labels& inner) {
  if (inner.size() != nested.random.back().labels.size()) return false;
  std::unordered_set<std::string> coarser;
  for (const std::string& label : nested.random.front().labels) coarser.insert(outer_part(label));
  Labels own;
  for (const std::string& label : nested.random.back().labels) {
    const NestedParts parts = nested_parts(label);
    if (!coarser.contains(std::string(parts.outer))) return false;
    own.emplace_back(parts.inner);
  }
  const bool is_repeated = std::unordered_set(own.begin(), own.end()).size() < own.size();
  return !is_repeated && have_same_labels(std::move(own), inner);
}

bool are_same(const Grouping& a, const Grouping& b) {
  if ((a.within == nullptr) == (b.within == nullptr)) {
    const bool is_nested_alike =
        a.within == nullptr || a.within->specification.random.front().group ==
                                   b.within->specification.random.front().group;
    return is_nested_alike && have_same_labels(*a.labels, *b.labels);
  }
  return a.within != nullptr ? are_unique_labels(*a.within, *b.labels)
                             : are_unique_labels(*b.within, *a.labels);
}

}  // namespace

std::string obstacle_to_same_groups(const FittedModel& larger,
                                    const FittedModel& smaller,
                                    const RandomEffects& term) {
  const std::string& group = term.group;
  const bool is_crossed =
      are_crossed(larger.specification.random) || are_crossed(smaller.specification.random);
  const Grouping large = is_crossed ? crossed_grouping(larger, term) : grouping_of(larger, group);
  const Grouping small = is_crossed ? crossed_grouping(smaller, term) : grouping_of(smaller, group);
  if (large.labels->empty() || small.labels->empty()) {
    return fmt::format(
        "a fit does not store its groups by {}, so it is unknown whether both fits have the same "
        "groups",
        group);
  }
  if (are_same(large, small)) return {};
  return fmt::format("the groups may differ: {} in the larger model, {} in the smaller",
                     large.text(group),
                     small.text(group));
}

}  // namespace silvafit::fit
