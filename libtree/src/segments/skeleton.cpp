// SPDX-License-Identifier: MIT
#include "silvafit/tree/skeleton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "morphology/crown_gaps.hpp"
#include "segments/branch_plan.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::tree {
namespace {

class SkeletonGrower {
 public:
  SkeletonGrower(const TreeShape& shape, const Crown& crown, const Preset& preset, Random& random)
      : shape_(shape), crown_(crown), preset_(preset), random_(random), gaps_(crown) {}

  Skeleton grow() {
    add_stem();
    const std::vector<PlannedBranch> branches =
        plan_branches(shape_, crown_, preset_, random_, skeleton_.notes);
    reserve(branches.size());
    for (const PlannedBranch& branch : branches) gaps_.occupy(branch.tip());
    for (const PlannedBranch& branch : branches) add_whole_branch(branch);
    return std::move(skeleton_);
  }

 private:
  void add_whole_branch(const PlannedBranch& branch) {
    const std::uint32_t axis = add_branch(branch);
    add_twigs(axis, branch.length_m(), preset_.twigs, preset_.shoots ? &*preset_.shoots : nullptr);
  }

  void reserve(std::size_t branches) {
    const auto most = [](const Twigs& twigs) {
      const std::size_t rows = twigs.arrangement == TwigArrangement::kPairs ? 2 : 1;
      return rows * static_cast<std::size_t>(twigs.most);
    };
    const std::size_t shoots = preset_.shoots ? most(*preset_.shoots) : 0;
    const std::size_t axes = 1 + branches * (1 + most(preset_.twigs) * (1 + shoots));
    skeleton_.axes.reserve(axes);
    skeleton_.points.reserve(skeleton_.points.size() + 3 * axes);
  }

  /// Straight up to the crown base and past breast height, where it is measured; above, it is
  /// curved if the preset says so, and returns to the axis at the tip.
  void add_stem() {
    const std::vector<double> heights = section_heights_m(shape_.h_m);
    const std::vector<double> radii = preset_.taper.radii_m(heights, shape_.h_m, shape_.dbh_cm);
    const double phase = random_.uniform(0.0, kTwoPi);
    skeleton_.points.reserve(heights.size());
    skeleton_.add_axis(0, 0);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      skeleton_.add_point(bent_axis(heights[i], phase), radii[i]);
    }
  }

  Point bent_axis(double z_m, double phase) const {
    constexpr double kTurns = 0.4;
    const double from = std::max(kBreastHeight, shape_.hcb_m);
    const double bend = preset_.branching.stem_bend;
    if (bend == 0.0 || z_m <= from || z_m >= shape_.h_m) return {0.0, 0.0, z_m};
    const double share = (z_m - from) / (shape_.h_m - from);
    // A short crown has no space for a bend.
    constexpr double kSteepest = 0.12;
    const double away = std::min(bend * shape_.radii.narrowest_m() * crown_.relative_width(z_m),
                                 kSteepest * (shape_.h_m - from)) *
                        std::sin(std::numbers::pi * share);
    const double angle = phase + kTwoPi * kTurns * share;
    return {away * std::cos(angle), away * std::sin(angle), z_m};
  }

  double branch_radius_m(const PlannedBranch& branch, double length_m, double stem_radius_m) const {
    const Branching& branching = preset_.branching;
    if (branch.is_limb) return std::max(branching.fork.thickness * stem_radius_m, kThinnestWoodM);
    const double by_length = 0.5 * branching.thickness * length_m;
    return std::max(std::min(by_length, branching.thickest * stem_radius_m), kThinnestWoodM);
  }

  /// A bowed line from the stem to the branch's tip between the crown curves.
  std::uint32_t add_branch(const PlannedBranch& branch) {
    const Branching& branching = preset_.branching;
    const std::uint32_t axis = skeleton_.add_axis(1, 0);
    SkeletonPoint base = at_height(skeleton_.points_of(skeleton_.axes.front()), branch.base_m);
    base.at = crown_.confine(base.at);
    const Point tip = branch.tip();
    const double length = branch.length_m();
    const double base_radius = branch_radius_m(branch, length, base.radius_m);
    const Point sideways = {-branch.outward.y, branch.outward.x, 0.0};
    skeleton_.add_point(base.at, base_radius);
    for (int i = 1; i < branching.segments; ++i) {
      const double share = static_cast<double>(i) / branching.segments;
      Point at = base.at + share * (tip - base.at);
      const double chord = at.z;
      const double bow = 4.0 * share * (1.0 - share) * length;
      if (branching.crookedness > 0.0) {
        at = at + branching.crookedness * bow * random_.uniform(-1.0, 1.0) * sideways;
      }
      const double distance = std::hypot(at.x, at.y);
      const double radius = crown_.radius_m(at.x, at.y);
      at.z = std::clamp(chord + bow * branching.sag,
                        std::min(chord, crown_.down_m(distance, radius)),
                        std::max(chord, crown_.up_m(distance, radius)));
      skeleton_.add_point(crown_.confine(at),
                          std::max((1.0 - share) * base_radius, kThinnestWoodM));
    }
    skeleton_.add_point(tip, 0.0);
    return axis;
  }

  SkeletonPoint along(const Axis& axis, double share) const {
    const auto points = skeleton_.points_of(axis);
    const double at = share * static_cast<double>(points.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(at), points.size() - 2);
    return between(points[below], points[below + 1], at - static_cast<double>(below));
  }

  /// Twigs along an axis, and shoots along each of them. All end at the crown curve.
  void add_twigs(std::uint32_t bearer, double length_m, const Twigs& twigs, const Twigs* shoots) {
    const auto points = skeleton_.points_of(skeleton_.axes[bearer]);
    const Frame frame = frame_along(points.back().at - points.front().at);
    const double bearing = 1.0 - twigs.from;
    const int number =
        std::clamp(static_cast<int>(length_m * bearing / twigs.spacing_m), twigs.least, twigs.most);
    const bool in_pairs = twigs.arrangement == TwigArrangement::kPairs;
    const double turn = in_pairs ? 0.0 : random_.uniform(0.0, kTwoPi);
    for (int i = 0; i < number; ++i) {
      const double share = (i + random_.uniform(0.3, 0.7)) / number;
      SkeletonPoint base = along(skeleton_.axes[bearer], twigs.from + bearing * share);
      // A crown with very unequal radii is concave between them; a crooked branch may leave it.
      base.at = crown_.confine(base.at);
      const double wanted =
          twigs.relative_length * length_m * (1.0 - (1.0 - twigs.tip_length) * share);
      const double spread = kRadian * twigs.spread_deg;
      if (in_pairs) {
        add_twig(bearer, base, frame, random_.uniform(-spread, spread), wanted, twigs, shoots);
        const double other = std::numbers::pi + random_.uniform(-spread, spread);
        add_twig(bearer, base, frame, other, wanted, twigs, shoots);
      } else {
        constexpr double kGoldenAngle = 137.5 * kRadian;
        const double azimuth = turn + kGoldenAngle * i + random_.uniform(-spread, spread);
        add_twig(bearer, base, frame, azimuth, wanted, twigs, shoots);
      }
    }
  }

  /// A straight line inside the crown.
  struct Line {
    Point along{};
    double length_m = 0.0;
  };

  /// \param azimuth  about the parent's axis, from its sideways direction
  Line twig_line(Point base,
                 const Frame& frame,
                 double angle,
                 double azimuth,
                 double wanted_m,
                 double lift) const {
    Point along =
        std::cos(angle) * frame.tangent +
        std::sin(angle) * (std::cos(azimuth) * frame.sideways + std::sin(azimuth) * frame.upward);
    if (lift != 0.0) along = direction(along + Point{0.0, 0.0, lift});
    return {along, crown_.length_inside_m(base, along, wanted_m)};
  }

  /// Of several buds around the parent's axis the one that ends farthest from other branches.
  Line line_in_gap(Point base,
                   const Frame& frame,
                   double angle,
                   double azimuth,
                   double wanted_m,
                   double lift) const {
    constexpr int kBuds = 6;
    Line best{};
    double widest = -1.0;
    for (int i = 0; i < kBuds; ++i) {
      const Line line = twig_line(base, frame, angle, azimuth + kTwoPi * i / kBuds, wanted_m, lift);
      const double gap = gaps_.squared_gap(base + line.length_m * line.along);
      if (gap <= widest) continue;
      widest = gap;
      best = line;
    }
    return best;
  }

  /// \param azimuth  about the parent's axis, from its sideways direction
  void add_twig(std::uint32_t bearer,
                const SkeletonPoint& base,
                const Frame& frame,
                double azimuth,
                double wanted_m,
                const Twigs& twigs,
                const Twigs* shoots) {
    const double angle = drawn_angle(random_, twigs.angle_low_deg, twigs.angle_high_deg);
    const bool in_gap = twigs.arrangement == TwigArrangement::kSpiral;
    const auto [along, length] =
        in_gap ? line_in_gap(base.at, frame, angle, azimuth, wanted_m, twigs.lift)
               : twig_line(base.at, frame, angle, azimuth, wanted_m, twigs.lift);
    // Parts outside the crown curve are cut off and have no twigs.
    constexpr double kShortest = 0.05;
    if (length < kShortest * wanted_m) return;
    if (in_gap) gaps_.occupy(base.at + length * along);
    const std::uint32_t axis = skeleton_.add_axis(skeleton_.axes[bearer].order + 1, bearer);
    const double radius = twigs.has_wood ? twig_radius_m(base.radius_m, length) : 0.0;
    skeleton_.add_point(base.at, radius);
    for (int i = 1; i < twigs.segments; ++i) {
      const double share = static_cast<double>(i) / twigs.segments;
      skeleton_.add_point(crooked(base.at, along, length, share),
                          std::max((1.0 - share) * radius, kThinnestWoodM));
    }
    skeleton_.add_point(base.at + length * along, 0.0);
    if (shoots != nullptr) add_twigs(axis, length, *shoots, nullptr);
  }

  double twig_radius_m(double bearer_radius_m, double length_m) const {
    constexpr double kOfBearer = 0.7;
    const double by_length = 0.5 * preset_.branching.thickness * length_m;
    return std::max(std::min(by_length, kOfBearer * bearer_radius_m), kThinnestWoodM);
  }

  Point crooked(Point base, Point along, double length_m, double share) {
    const Point at = base + share * length_m * along;
    const double stray = preset_.branching.crookedness * 4.0 * share * (1.0 - share) * length_m;
    if (stray == 0.0) return at;
    return crown_.confine(at + Point{stray * random_.uniform(-1.0, 1.0),
                                     stray * random_.uniform(-1.0, 1.0),
                                     stray * random_.uniform(-1.0, 1.0)});
  }

  const TreeShape& shape_;
  const Crown& crown_;
  const Preset& preset_;
  Random& random_;
  CrownGaps gaps_;
  Skeleton skeleton_;
};

}  // namespace

Random random_of_tree(std::uint64_t seed, std::string_view plot, std::string_view tree) {
  // The separator distinguishes plot 1, tree 12 from plot 11, tree 2.
  Fingerprint label;
  label.add(plot);
  label.add(std::string_view("\0", 1));
  label.add(tree);
  return Random(seed, label.value());
}

std::vector<double> section_heights_m(double h_m) {
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

Skeleton SegmentBuilder::grow_skeleton(const TreeShape& shape,
                                       const Crown& crown,
                                       Random& random,
                                       const MeshOptions& /*mesh*/) const {
  return SkeletonGrower(shape, crown, preset_, random).grow();
}

}  // namespace silvafit::tree
