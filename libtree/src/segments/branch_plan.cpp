// SPDX-License-Identifier: MIT
#include "segments/branch_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "morphology/crown_gaps.hpp"
#include "silvafit/base/constants.hpp"

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

namespace {

class Planner {
 public:
  Planner(const Crown& crown, const Branching& branching, Random& random)
      : crown_(crown), branching_(branching), random_(random) {}

  /// Of several buds at one height the one that ends farthest from other branches and from the
  /// stem.
  PlannedBranch branch_in_gap(double base_m, double turn, const CrownGaps& gaps) {
    constexpr int kBuds = 8;
    PlannedBranch best{};
    double widest = -1.0;
    for (int i = 0; i < kBuds; ++i) {
      const double azimuth = turn + 2.0 * std::numbers::pi * i / kBuds +
                             random_.normal(0.0, branching_.azimuth_sd_deg * kRadian);
      const PlannedBranch bud = branch(base_m, azimuth);
      const Point tip = bud.tip();
      const double gap = std::min(gaps.squared_gap(tip), gaps.squared_from_stem(tip));
      if (gap <= widest) continue;
      widest = gap;
      best = bud;
    }
    return best;
  }

  PlannedBranch branch(double base_m, double azimuth_rad) {
    PlannedBranch branch{.base_m = base_m,
                         .outward = {std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0}};
    const double radius = crown_.radius_m(branch.outward.x, branch.outward.y);
    const AngleLayer& layer = layer_at(base_m);
    aim(branch, draw_angle(layer), radius);
    // At the crown base a flat branch would leave a concave crown at once: turn it up, first within
    // its layer, then until it reaches a quarter of the radius.
    // A single branch must reach farther than one of a whorl, or it is a tuft at the stem.
    const bool is_single = branching_.arrangement == Arrangement::kSpiral;
    const double kShortest = is_single ? 0.4 : 0.02;
    const double kReach = is_single ? 0.5 : 0.25;
    const bool below_widest = base_m < crown_.hc_m();
    if (below_widest && branch.distance_m < kShortest * radius) {
      aim(branch, layer.low_deg * kRadian, radius);
    }
    if (below_widest && branch.distance_m < kShortest * radius) {
      const double reach = kReach * radius;
      const double rise = crown_.down_m(reach, radius) - base_m;
      if (rise > 0.0) aim(branch, std::atan2(reach, rise), radius);
    }
    return branch;
  }

  /// One of the limbs into which the stem divides; they are distributed all round.
  PlannedBranch limb(int number, double turn) {
    const Fork& fork = branching_.fork;
    const double azimuth = turn + 2.0 * std::numbers::pi * number / fork.limbs +
                           random_.normal(0.0, branching_.azimuth_sd_deg * kRadian);
    const double length = crown_.h_m() - crown_.hcb_m();
    PlannedBranch branch{.base_m = crown_.hcb_m() + length * random_.uniform(fork.from, fork.to),
                         .outward = {std::sin(azimuth), std::cos(azimuth), 0.0},
                         .is_limb = true};
    aim(branch,
        kRadian * random_.uniform(fork.low_deg, fork.high_deg),
        crown_.radius_m(branch.outward.x, branch.outward.y));
    return branch;
  }

  /// The branch that ends at the crown's widest point in one of the four measured directions. It is
  /// flatter than its layer if it would otherwise start below the crown base.
  PlannedBranch widest(Point outward) {
    const double radius = crown_.radius_m(outward.x, outward.y);
    const double steepest = std::atan2(radius, crown_.hc_m() - crown_.hcb_m());
    const double angle = std::max(draw_angle(layer_at(crown_.hc_m())), steepest);
    const double rise = radius / std::tan(angle);
    return {.base_m = std::max(crown_.hc_m() - rise, crown_.hcb_m()),
            .angle_rad = angle,
            .outward = outward,
            .distance_m = radius};
  }

 private:
  const AngleLayer& layer_at(double z_m) const {
    const double share = (z_m - crown_.hcb_m()) / (crown_.h_m() - crown_.hcb_m());
    const auto above = std::find_if(
        branching_.layers.begin() + 1, branching_.layers.end(), [share](const AngleLayer& layer) {
          return layer.from > share;
        });
    return *(above - 1);
  }

  double draw_angle(const AngleLayer& layer) {
    return drawn_angle(random_, layer.low_deg, layer.high_deg);
  }

  void aim(PlannedBranch& branch, double angle_rad, double radius_m) const {
    branch.angle_rad = angle_rad;
    branch.distance_m = crown_.matching_distance_m(branch.base_m, angle_rad, radius_m);
  }

  const Crown& crown_;
  const Branching& branching_;
  Random& random_;
};

/// Branches one above the other, each of them in the largest gap between the limbs, the branches at
/// the measured radii, and those before it.
std::vector<PlannedBranch> spiral_branches(const std::vector<Whorl>& heights,
                                           const Crown& crown,
                                           const Branching& branching,
                                           double turn,
                                           Planner& planner) {
  std::vector<PlannedBranch> last;
  for (int i = 0; i < branching.fork.limbs; ++i) last.push_back(planner.limb(i, turn));
  for (const Point outward : Crown::kMeasured) last.push_back(planner.widest(outward));
  CrownGaps gaps(crown);
  for (const PlannedBranch& branch : last) gaps.occupy(branch.tip());
  std::vector<PlannedBranch> branches;
  branches.reserve(heights.size() + last.size());
  for (const Whorl& height : heights) {
    turn += branching.divergence_deg * kRadian;
    branches.push_back(planner.branch_in_gap(height.base_m, turn, gaps));
    gaps.occupy(branches.back().tip());
  }
  branches.insert(branches.end(), last.begin(), last.end());
  return branches;
}

}  // namespace

double PlannedBranch::length_m() const { return distance_m / std::sin(angle_rad); }

Point PlannedBranch::tip() const {
  return {outward.x * distance_m,
          outward.y * distance_m,
          base_m + distance_m * std::cos(angle_rad) / std::sin(angle_rad)};
}

std::vector<PlannedBranch> plan_branches(const TreeShape& shape,
                                         const Crown& crown,
                                         const Preset& preset,
                                         Random& random,
                                         std::vector<Note>& notes) {
  // East, west, south, north, and the limbs.
  constexpr int kMeasured = 4;
  const Branching& branching = preset.branching;
  const std::vector<Whorl> whorls =
      plan_whorls(shape, preset, kMeasured + branching.fork.limbs, random, notes);

  Planner planner(crown, branching, random);
  double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
  if (branching.arrangement == Arrangement::kSpiral) {
    return spiral_branches(whorls, crown, branching, turn, planner);
  }
  std::vector<PlannedBranch> branches;
  branches.reserve(static_cast<std::size_t>(branching.most) + kMeasured + 8);
  int direction = 0;
  for (std::size_t w = 0; w < whorls.size(); ++w) {
    const Whorl& whorl = whorls[w];
    const double next_m = w + 1 < whorls.size() ? whorls[w + 1].base_m : crown.h_m();
    const double spread_m = branching.whorl_spread * std::max(next_m - whorl.base_m, 0.0);
    turn += random.uniform(0.0, 2.0 * std::numbers::pi);
    const int directions = std::max(whorl.branches, branching.per_whorl);
    for (int i = 0; i < whorl.branches; ++i, ++direction) {
      const double azimuth = turn + 2.0 * std::numbers::pi * (direction % directions) / directions +
                             random.normal(0.0, branching.azimuth_sd_deg * kRadian);
      // The first branch stays at the whorl's height: the lowest one is at the measured crown base.
      const double above_m = i > 0 && spread_m > 0.0 ? spread_m * random.uniform(0.0, 1.0) : 0.0;
      branches.push_back(planner.branch(whorl.base_m + above_m, azimuth));
    }
  }
  for (int i = 0; i < branching.fork.limbs; ++i) branches.push_back(planner.limb(i, turn));
  for (const Point outward : Crown::kMeasured) branches.push_back(planner.widest(outward));
  return branches;
}

}  // namespace silvafit::tree
