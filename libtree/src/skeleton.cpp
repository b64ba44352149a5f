// SPDX-License-Identifier: MIT
#include "silvafit/tree/skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "branch_plan.hpp"

namespace silvafit::tree {
namespace {

constexpr double kRadian = std::numbers::pi / 180.0;

class SkeletonGrower {
 public:
  SkeletonGrower(const TreeShape& shape, const Crown& crown, const Preset& preset, Random& random)
      : shape_(shape), crown_(crown), preset_(preset), random_(random) {}

  Skeleton grow() {
    add_stem();
    for (const PlannedBranch& branch :
         plan_branches(shape_, crown_, preset_, random_, skeleton_.notes)) {
      const std::uint32_t axis = add_branch(branch);
      add_twigs(axis, branch);
    }
    return std::move(skeleton_);
  }

 private:
  std::uint32_t begin_axis(std::uint32_t order, std::uint32_t parent) {
    const auto first = static_cast<std::uint32_t>(skeleton_.points.size());
    skeleton_.axes.push_back({.order = order, .parent = parent, .first = first, .count = 0});
    return static_cast<std::uint32_t>(skeleton_.axes.size() - 1);
  }

  void add_point(Point at, double radius_m) {
    skeleton_.points.push_back({at, radius_m});
    ++skeleton_.axes.back().count;
  }

  void add_stem() {
    const std::vector<double> heights = section_heights_m(shape_.h_m);
    const std::vector<double> diameters =
        preset_.taper.diameters_cm(heights, shape_.h_m, shape_.dbh_cm);
    begin_axis(0, 0);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      constexpr double kRadiusPerDiameter = 0.5 * 0.01;
      add_point({0.0, 0.0, heights[i]}, diameters[i] * kRadiusPerDiameter);
    }
  }

  double stem_radius_m(double z_m) const {
    const auto stem = skeleton_.points_of(skeleton_.axes.front());
    const auto above =
        std::lower_bound(stem.begin(), stem.end(), z_m, [](const SkeletonPoint& point, double z) {
          return point.at.z < z;
        });
    if (above == stem.begin()) return stem.front().radius_m;
    if (above == stem.end()) return 0.0;
    const SkeletonPoint& below = *(above - 1);
    const double part = (z_m - below.at.z) / (above->at.z - below.at.z);
    return below.radius_m + part * (above->radius_m - below.radius_m);
  }

  /// A bowed line from the axis to the branch's tip that stays between the crown curves.
  std::uint32_t add_branch(const PlannedBranch& branch) {
    const std::uint32_t axis = begin_axis(1, 0);
    const Point tip = branch.tip();
    const double reach = branch.length_m();
    // No branch is thicker than half the stem that bears it.
    const double base_radius =
        std::min(preset_.branching.thickness * reach, 0.5 * stem_radius_m(branch.base_m));
    const double crown_radius = crown_.radius_m(branch.outward.x, branch.outward.y);
    const int segments = preset_.twigs.has_wood ? 3 : 2;
    add_point({0.0, 0.0, branch.base_m}, base_radius);
    for (int i = 1; i < segments; ++i) {
      const double share = static_cast<double>(i) / segments;
      const double distance = share * branch.distance_m;
      const double chord = branch.base_m + share * (tip.z - branch.base_m);
      const double bow = 4.0 * share * (1.0 - share) * preset_.branching.sag * reach;
      const double z = std::clamp(chord + bow,
                                  std::min(chord, crown_.down_m(distance, crown_radius)),
                                  std::max(chord, crown_.up_m(distance, crown_radius)));
      add_point({branch.outward.x * distance, branch.outward.y * distance, z},
                (1.0 - share) * base_radius);
    }
    add_point(tip, 0.0);
    return axis;
  }

  SkeletonPoint along(std::uint32_t axis, double share) const {
    const auto points = skeleton_.points_of(skeleton_.axes[axis]);
    const double at = share * static_cast<double>(points.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(at), points.size() - 2);
    const double part = at - static_cast<double>(below);
    const SkeletonPoint& a = points[below];
    const SkeletonPoint& b = points[below + 1];
    return {a.at + part * (b.at - a.at), a.radius_m + part * (b.radius_m - a.radius_m)};
  }

  void add_twigs(std::uint32_t axis, const PlannedBranch& branch) {
    const Twigs& twigs = preset_.twigs;
    const double reach = branch.length_m();
    const double bearing = 1.0 - twigs.from;
    // Twigs stand in two rows, hence twice as many as the spacing in one row gives.
    const int number = std::clamp(
        static_cast<int>(2.0 * reach * bearing / twigs.spacing_m), twigs.least, twigs.most);
    const Point tangent = direction(branch.tip() - Point{0.0, 0.0, branch.base_m});
    const Point sideways = {-branch.outward.y, branch.outward.x, 0.0};
    const Point upward = cross(tangent, sideways);
    for (int i = 0; i < number; ++i) {
      const double share = (i + random_.uniform(0.3, 0.7)) / number;
      const SkeletonPoint base = along(axis, twigs.from + bearing * share);
      const double angle = draw_twig_angle();
      const double tilt = kRadian * random_.uniform(-twigs.spread_deg, twigs.spread_deg);
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Point lateral = side * std::cos(tilt) * sideways + std::sin(tilt) * upward;
      const Point along_twig = std::cos(angle) * tangent + std::sin(angle) * lateral;
      // Longest near the base, a quarter of it at the tip: the outline of a spray.
      const double wanted = twigs.relative_length * reach * (1.0 - 0.75 * share);
      const Point tip = crown_.confine(base.at + wanted * along_twig);
      if (length(tip - base.at) < 0.05 * wanted) continue;
      begin_axis(2, axis);
      add_point(base.at, twigs.has_wood ? 0.5 * base.radius_m : 0.0);
      add_point(tip, 0.0);
    }
  }

  double draw_twig_angle() {
    const double low = preset_.twigs.angle_low_deg;
    const double high = preset_.twigs.angle_high_deg;
    return kRadian * random_.truncated_normal(0.5 * (low + high), 0.25 * (high - low), low, high);
  }

  const TreeShape& shape_;
  const Crown& crown_;
  const Preset& preset_;
  Random& random_;
  Skeleton skeleton_;
};

}  // namespace

Random random_of_tree(std::uint64_t seed, std::string_view plot, std::string_view tree) {
  // FNV-1a over both texts; the separator keeps plot 1, tree 12 apart from plot 11, tree 2.
  std::uint64_t hash = 0xcbf29ce484222325U;
  const auto mix = [&hash](std::string_view text) {
    for (const char c : text) {
      hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
    }
  };
  mix(plot);
  mix(std::string_view("\0", 1));
  mix(tree);
  return Random(seed, hash);
}

std::vector<double> section_heights_m(double h_m) {
  constexpr double kBreastHeight = 1.3;
  constexpr int kSectionsPerMeter = 5;
  std::vector<double> heights;
  heights.reserve(static_cast<std::size_t>(h_m * kSectionsPerMeter) + 3);
  for (int i = 0;; ++i) {
    const double z = static_cast<double>(i) / kSectionsPerMeter;
    if (z >= h_m) break;
    if (z > kBreastHeight && heights.back() < kBreastHeight) heights.push_back(kBreastHeight);
    heights.push_back(z);
  }
  if (heights.back() < kBreastHeight) heights.push_back(kBreastHeight);
  heights.push_back(h_m);
  return heights;
}

Skeleton grow_skeleton(const TreeShape& shape,
                       const Crown& crown,
                       const Preset& preset,
                       Random& random) {
  return SkeletonGrower(shape, crown, preset, random).grow();
}

}  // namespace silvafit::tree
