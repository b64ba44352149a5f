// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include "growth/growth_parts.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"

namespace silvafit::stand {

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
