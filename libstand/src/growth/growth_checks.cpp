// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "growth/growth_parts.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::stand {

namespace {

/// Trees of two successive times of a plot.
struct TwoTimes {
  std::size_t first = 0;      ///< with a row at the first
  std::size_t second = 0;     ///< at the second
  std::size_t both = 0;       ///< at both
  std::size_t surviving = 0;  ///< with a row before and after the second: alive then
  std::size_t found = 0;      ///< of these, with a row at the second
  std::size_t fresh = 0;      ///< with their first row at the second
};

TwoTimes trees_of_times(const MeasuredPlot& plot, std::size_t k) {
  TwoTimes result;
  const auto next = static_cast<std::ptrdiff_t>(k + 1);
  const auto has_row = [](const auto& row) { return row.has_value(); };
  for (const MeasuredTree& tree : plot.trees) {
    const auto middle = tree.rows.begin() + next;
    const bool is_before = std::any_of(tree.rows.begin(), middle, has_row);
    const bool is_after = std::any_of(middle + 1, tree.rows.end(), has_row);
    const bool is_there = middle->has_value();
    result.first += tree.rows[k] ? 1 : 0;
    result.second += is_there ? 1 : 0;
    result.both += tree.rows[k] && is_there ? 1 : 0;
    result.surviving += is_before && is_after ? 1 : 0;
    result.found += is_before && is_after && is_there ? 1 : 0;
    result.fresh += !is_before && is_there ? 1 : 0;
  }
  return result;
}

/// Why the second time is no visit; empty if it is one. At a visit most living trees are found. A
/// time at which some trees are measured once more and none is new does no harm over more than a
/// season, since the others are interpolated.
std::string objection(const TwoTimes& trees, double years) {
  // Shorter than a season of growth.
  constexpr double kShortestYears = 0.25;
  if (years < kShortestYears && 2 * trees.both < std::max(trees.first, trees.second)) {
    return fmt::format("{} of {} trees of the time before have a row, and {} in all",
                       trees.both,
                       trees.first,
                       counted(trees.second, "tree has one", "trees have one"));
  }
  const bool is_part = trees.second == 0 || trees.fresh > 0;
  if (!is_part || 2 * trees.found >= trees.surviving) return {};
  return fmt::format("{} of {} that live before and after have a row{}",
                     trees.found,
                     counted(trees.surviving, "tree", "trees"),
                     trees.fresh > 0 ? ", and others are new" : "");
}

}  // namespace

void check_visits(const std::vector<MeasuredPlot>& plots, const std::string& file) {
  bool has_period = false;
  bool has_followed = false;
  for (const MeasuredPlot& plot : plots) {
    for (std::size_t k = 0; k + 1 < plot.occasions.size(); ++k) {
      const TwoTimes trees = trees_of_times(plot, k);
      if (trees.first > 0 && trees.second > 0) {
        has_period = true;
        has_followed = has_followed || trees.both > 0;
      }
      const std::string reason =
          objection(trees, plot.occasions[k + 1].years - plot.occasions[k].years);
      if (reason.empty()) continue;
      throw InputError(
          fmt::format(
              "{} after {} seems to be no visit of its own: {}; give all rows of a visit of "
              "a plot, and of its table of plots, the same year or date",
              plot.occasions[k + 1].text,
              plot.occasions[k].text,
              reason),
          {.file = file, .column = "year", .plot = plot.plot});
    }
  }
  if (!has_period || has_followed) return;
  throw InputError(
      "no tree has rows at two successive times of its plot; trees must keep their numbers, and "
      "`columns=tree=COLUMN` names their column",
      {.file = file, .column = "tree"});
}

void refuse_other_trees(const GrowthReport& report, const std::string& file) {
  // One or two trees may be errors.
  constexpr std::size_t kFewest = 3;
  std::size_t survivors = 0;
  std::size_t others = 0;
  std::string first;
  for (const TreeGrowth& tree : report.trees) {
    if (tree.fate != TreeFate::kSurvivor || tree.is_interpolated) continue;
    ++survivors;
    const bool is_other = tree.is_renamed ||
                          tree.dbh_end_cm < (1.0 - kLargestLoss) * tree.dbh_start_cm ||
                          tree.dbh_cm_per_year > kFastestCmPerYear;
    if (is_other && others++ == 0) {
      first = fmt::format("plot {}, tree {}, {} to {}", tree.plot, tree.tree, tree.from, tree.to);
    }
  }
  if (survivors < kFewest || 2 * others <= survivors) return;
  throw InputError(
      fmt::format(
          "{} of {} trees are others at the end of a period: of another species, thinner by "
          "more than {:g} % or thicker by more than {} cm per year (the first: {}); trees "
          "must keep their numbers, and `columns=tree=COLUMN` names their column; if only "
          "the codes of the species changed, give them the same ones",
          others,
          survivors,
          100.0 * kLargestLoss,
          kFastestCmPerYear,
          first),
      {.file = file, .column = "tree"});
}

void check_increments(const GrowthReport& report, const std::string& file) {
  // Single trees have errors of all sizes.
  constexpr std::size_t kFewest = 3;
  struct Changes {
    std::vector<double> start_cm{};
    std::vector<double> ratio{};
    double years = 0.0;
  };
  std::map<std::tuple<std::string, std::string, std::string>, Changes> all;
  for (const TreeGrowth& tree : report.trees) {
    const double ratio = tree.dbh_end_cm / tree.dbh_start_cm;
    if (!std::isfinite(ratio) || tree.is_interpolated) continue;
    Changes& one = all[{tree.plot, tree.from, tree.to}];
    one.start_cm.push_back(tree.dbh_start_cm);
    one.ratio.push_back(ratio);
    one.years = tree.years;
  }
  for (const auto& [period, one] : all) {
    if (one.ratio.size() < kFewest) continue;
    const double start_cm = median(one.start_cm);
    const double ratio = median(one.ratio);
    const bool is_possible =
        (ratio - 1.0) * start_cm <= kFastestCmPerYear * one.years && ratio >= 1.0 - kLargestLoss;
    if (is_possible) continue;
    const auto& [plot, from, to] = period;
    throw InputError(
        fmt::format("from {} to {} the dbh of the median of {} trees was multiplied by {:.3g}, "
                    "which no stand does; one visit seems to be in another unit (mm: 10, inches: "
                    "2.54, circumference: 3.14): convert its rows, or use `trust_units`",
                    from,
                    to,
                    one.ratio.size(),
                    ratio),
        {.file = file, .column = "dbh", .plot = plot});
  }
}

}  // namespace silvafit::stand
