// SPDX-License-Identifier: MIT
#include "branch_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace silvafit::tree {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadian = kPi / 180.0;

int branches_by_spacing(const TreeShape& shape, const Branching& branching) {
  const double rounds = std::round((shape.h_m - shape.hcb_m) / branching.spacing_m);
  return static_cast<int>(rounds) * branching.per_whorl;
}

int branches_by_age(double age_years, const BranchCount& equations, std::vector<Note>& notes) {
  const BranchCount::Count count = equations.at(age_years);
  if (count.clamped) {
    notes.push_back({"branch_count",
                     fmt::format("age {} is outside the {} to {} years of {}; age {} is used",
                                 age_years,
                                 equations.youngest_years(),
                                 equations.oldest_years(),
                                 equations.name(),
                                 count.age_years)});
  }
  return static_cast<int>(std::lround(count.live()));
}

int number_of_branches(const TreeShape& shape, const Preset& preset, std::vector<Note>& notes) {
  const Branching& branching = preset.branching;
  if (!preset.branch_count || !shape.age_years) {
    return std::clamp(branches_by_spacing(shape, branching), branching.least, branching.most);
  }
  const int wanted = branches_by_age(*shape.age_years, *preset.branch_count, notes);
  const int number = std::clamp(wanted, branching.least, branching.most);
  if (number != wanted) {
    notes.push_back({"branch_count",
                     fmt::format("{} living branches by age; the preset {} draws {} to {}",
                                 wanted,
                                 preset.name,
                                 branching.least,
                                 branching.most)});
  }
  return number;
}

class Planner {
 public:
  Planner(const Crown& crown, const Branching& branching, Random& random)
      : crown_(crown), branching_(branching), random_(random) {}

  PlannedBranch branch(double base_m, double azimuth_rad) {
    PlannedBranch branch{.base_m = base_m,
                         .outward = {std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0}};
    const double radius = crown_.radius_m(branch.outward.x, branch.outward.y);
    const AngleLayer& layer = layer_at(base_m);
    aim(branch, draw_angle(layer), radius);
    // At the crown base a flat branch leaves a hollow crown at once: turn it up, first within its
    // layer, then as far as it takes to reach a quarter of the radius.
    constexpr double kShortest = 0.02;
    constexpr double kReach = 0.25;
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

  /// The branch that ends on the crown's widest point in one of the four measured directions. It is
  /// flatter than its layer has it where it would otherwise start below the crown base.
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
    const double middle = 0.5 * (layer.low_deg + layer.high_deg);
    const double sd = 0.25 * (layer.high_deg - layer.low_deg);
    return kRadian * random_.truncated_normal(middle, sd, layer.low_deg, layer.high_deg);
  }

  void aim(PlannedBranch& branch, double angle_rad, double radius_m) const {
    branch.angle_rad = angle_rad;
    branch.distance_m = crown_.matching_distance_m(branch.base_m, angle_rad, radius_m);
  }

  const Crown& crown_;
  const Branching& branching_;
  Random& random_;
};

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
  const Branching& branching = preset.branching;
  const int number = number_of_branches(shape, preset, notes);
  const int rounds = (number + branching.per_whorl - 1) / branching.per_whorl;
  const double crown_length = shape.h_m - shape.hcb_m;
  const bool spiral = branching.arrangement == Arrangement::kSpiral;

  Planner planner(crown, branching, random);
  std::vector<PlannedBranch> branches;
  branches.reserve(static_cast<std::size_t>(rounds * branching.per_whorl) + 4);
  double turn = random.uniform(0.0, 2.0 * kPi);
  for (int round = 0; round < rounds; ++round) {
    // The lowest round stays at the crown base, which is measured.
    const double jitter = round == 0 ? 0.0 : random.uniform(-0.2, 0.2);
    const double from_tip = 1.0 - (round + jitter) / rounds;
    const double base =
        shape.hcb_m + crown_length * (1.0 - std::pow(from_tip, branching.tip_density));
    turn += spiral ? branching.divergence_deg * kRadian : random.uniform(0.0, 2.0 * kPi);
    for (int i = 0; i < branching.per_whorl; ++i) {
      const double azimuth = turn + 2.0 * kPi * i / branching.per_whorl +
                             random.normal(0.0, branching.azimuth_sd_deg * kRadian);
      branches.push_back(planner.branch(base, azimuth));
    }
  }
  for (const Point outward : {Point{1, 0, 0}, Point{-1, 0, 0}, Point{0, -1, 0}, Point{0, 1, 0}}) {
    branches.push_back(planner.widest(outward));
  }
  return branches;
}

}  // namespace silvafit::tree
