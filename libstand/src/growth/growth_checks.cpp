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

namespace silvafit::stand {

void check_visits(const std::vector<MeasuredPlot>& plots, const std::string& file) {
  // Shorter periods are days of one visit, on which other trees were measured.
  constexpr double kShortestYears = 0.25;
  bool has_period = false;
  bool has_followed = false;
  for (const MeasuredPlot& plot : plots) {
    for (std::size_t k = 0; k + 1 < plot.occasions.size(); ++k) {
      std::size_t first = 0;
      std::size_t second = 0;
      std::size_t both = 0;
      for (const MeasuredTree& tree : plot.trees) {
        first += tree.rows[k] ? 1 : 0;
        second += tree.rows[k + 1] ? 1 : 0;
        both += tree.rows[k] && tree.rows[k + 1] ? 1 : 0;
      }
      if (first == 0 || second == 0) continue;
      has_period = true;
      has_followed = has_followed || both > 0;
      const double years = plot.occasions[k + 1].years - plot.occasions[k].years;
      if (years >= kShortestYears || 2 * both >= std::min(first, second)) continue;
      throw InputError(
          fmt::format("{} of {} trees of {} have a row at {}, too: these seem to be days of one "
                      "visit; give all rows of a visit of a plot the same year or date",
                      both,
                      first,
                      plot.occasions[k].text,
                      plot.occasions[k + 1].text),
          {.file = file, .column = "year", .plot = plot.plot});
    }
  }
  if (!has_period || has_followed) return;
  throw InputError(
      "no tree has rows at two successive times of its plot; trees must keep their numbers, and "
      "`columns=tree=COLUMN` names their column",
      {.file = file, .column = "tree"});
}

void check_increments(const GrowthReport& report, const std::string& file) {
  // Single trees have errors of all sizes.
  constexpr std::size_t kFewest = 3;
  // Lost bark and errors of tapes are a few percent of dbh.
  constexpr double kLargestLoss = 0.25;
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
