// SPDX-License-Identifier: MIT
#include "segments/whorls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace silvafit::tree {
namespace {

int branches_by_spacing(const TreeShape& shape, const Branching& branching) {
  const double rounds = std::round((shape.h_m - shape.hcb_m) / branching.spacing_m);
  return static_cast<int>(rounds) * branching.per_whorl;
}

/// By the equations, or by the spacing of trees of unknown age beyond their range.
/// \param bound  branches that are planned elsewhere and count, too
int number_of_branches(const TreeShape& shape,
                       const Preset& preset,
                       int bound,
                       std::vector<Note>& notes) {
  const Branching& branching = preset.branching;
  const int by_spacing =
      bound +
      std::clamp(branches_by_spacing(shape, branching) - bound, branching.least, branching.most);
  if (!preset.branch_count || !shape.age_years) return by_spacing;
  const BranchCount& equations = *preset.branch_count;
  const auto count = equations.at(*shape.age_years);
  if (!count) {
    notes.push_back(
        {"branch_count",
         fmt::format("age {} is outside the range of {} to {} years of {}; the tree has "
                     "{} branches, as one of unknown age",
                     *shape.age_years,
                     equations.youngest_years(),
                     equations.oldest_years(),
                     equations.name(),
                     by_spacing)});
    return by_spacing;
  }
  const int wanted = static_cast<int>(std::lround(count->live()));
  const int number = std::clamp(wanted, branching.least, branching.most);
  if (number != wanted) {
    notes.push_back({"branch_count",
                     fmt::format("{} living branches by age; the preset {} gives {} to {}",
                                 wanted,
                                 preset.name,
                                 branching.least,
                                 branching.most)});
  }
  return number;
}

/// Whole rounds, closer to each other towards the tip if the preset says so.
std::vector<Whorl> even_whorls(const TreeShape& shape,
                               const Branching& branching,
                               int number,
                               Random& random) {
  const int rounds = (number + branching.per_whorl - 1) / branching.per_whorl;
  const double crown_length = shape.h_m - shape.hcb_m;
  std::vector<Whorl> whorls(static_cast<std::size_t>(rounds));
  for (int round = 0; round < rounds; ++round) {
    // The lowest round stays at the crown base, which is measured.
    const double jitter = round == 0 ? 0.0 : random.uniform(-0.2, 0.2);
    const double from_tip = 1.0 - (round + jitter) / rounds;
    whorls[static_cast<std::size_t>(round)] = {
        .base_m = shape.hcb_m + crown_length * (1.0 - std::pow(from_tip, branching.tip_density)),
        .branches = branching.per_whorl};
  }
  return whorls;
}

/// Heights of the whorls, which are spread along the shoot of each year.
std::vector<double> yearly_heights_m(const TreeShape& shape,
                                     const YearlyWhorls& yearly,
                                     Random& random) {
  const double shoot_m = shape.h_m / *shape.age_years;
  const auto range = static_cast<std::uint64_t>(yearly.high - yearly.low) + 1;
  std::vector<double> heights;
  const double first_year = std::floor(shape.hcb_m / shoot_m);
  for (double year = first_year; year < *shape.age_years; year += 1.0) {
    const int number = yearly.low + static_cast<int>(random.below(range));
    for (int i = 0; i < number; ++i) {
      const double base = (year + static_cast<double>(i) / number) * shoot_m;
      if (base >= shape.hcb_m && base < shape.h_m) heights.push_back(base);
    }
  }
  return heights;
}

/// The number of branches distributed evenly over the heights, as integers; heights without
/// branches are skipped.
std::vector<Whorl> spread_over(const std::vector<double>& heights, int number) {
  std::vector<Whorl> whorls;
  const double each = number / static_cast<double>(heights.size());
  int spent = 0;
  for (std::size_t i = 0; i < heights.size(); ++i) {
    const int until = static_cast<int>(std::lround(each * static_cast<double>(i + 1)));
    if (until > spent) whorls.push_back({.base_m = heights[i], .branches = until - spent});
    spent = until;
  }
  return whorls;
}

}  // namespace

std::vector<Whorl> plan_whorls(const TreeShape& shape,
                               const Preset& preset,
                               int bound,
                               Random& random,
                               std::vector<Note>& notes) {
  const Branching& branching = preset.branching;
  const int number = std::max(number_of_branches(shape, preset, bound, notes) - bound, 1);
  if (!preset.branch_count || !shape.age_years || !branching.yearly) {
    return even_whorls(shape, branching, number, random);
  }
  std::vector<double> heights = yearly_heights_m(shape, *branching.yearly, random);
  if (heights.empty()) heights.push_back(shape.hcb_m);
  std::vector<Whorl> whorls = spread_over(heights, number);
  whorls.front().base_m = shape.hcb_m;
  return whorls;
}

}  // namespace silvafit::tree
