// SPDX-License-Identifier: MIT
#include "mesh/aerial_roots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "mesh/jitter.hpp"
#include "mesh/tube.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

/// Sections: proportion of the length, radius relative to the root's.
using Section = std::array<double, 2>;
/// A prop, from its foot to its end inside the wood that bears it.
constexpr std::array<Section, 7> kProp{
    {{0.0, 1.9}, {0.04, 1.35}, {0.12, 1.05}, {0.4, 0.95}, {0.7, 1.0}, {0.97, 1.3}, {1.0, 0.0}}};
/// A hanging root, from its limb to its tip.
constexpr std::array<Section, 3> kHanging{{{0.0, 1.0}, {0.5, 0.8}, {1.0, 0.0}}};

/// Where roots leave a limb: at about equal distances along an axis, beyond its first part.
template <typename Use>
void along_limb(std::span<const SkeletonPoint> line, double spacing_m, Jitter& jitter, Use use) {
  constexpr double kBare = 0.25;
  const double whole = line_length_m(line);
  double passed = 0.0;
  double next = kBare * whole + spacing_m * (0.5 + 0.5 * jitter.next());
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double size = length(line[i].at - line[i - 1].at);
    while (next < passed + size) {
      use(between(line[i - 1], line[i], (next - passed) / size));
      next += spacing_m * (1.0 + 0.5 * jitter.next());
    }
    passed += size;
  }
}

class RootWriter {
 public:
  RootWriter(const AerialRoots& roots, const MeshOptions& options, PartBuilder& build)
      : roots_(roots),
        options_(options),
        of_prop_(equal_area_corners(options.branch_sides)),
        of_root_(equal_area_corners(options.twig_sides)),
        build_(build) {}

  /// Draws the same numbers at every level of detail.
  void add(const SkeletonPoint& base, double stem_radius_m, Jitter& jitter) {
    const double kind = 0.5 + 0.5 * jitter.next();
    const double size = 0.5 + 0.5 * jitter.next();
    const double bend = jitter.next();
    constexpr double kThinnestLimb = 0.025;
    constexpr double kLowest = 0.3;
    if (base.radius_m < kThinnestLimb || base.at.z < kLowest) return;
    // Beside the stem a root would grow into it; thin limbs have no old roots.
    constexpr double kFromStem = 3.0;
    constexpr double kThinnestPropped = 0.04;
    const bool is_prop = kind < roots_.props && base.radius_m > kThinnestPropped &&
                         std::hypot(base.at.x, base.at.y) > kFromStem * stem_radius_m;
    constexpr double kOfLimb = 0.7;
    const double thickest = std::min(0.5 * roots_.diameter_m, kOfLimb * base.radius_m);
    if (is_prop) {
      // An old prop thickens from the ground on and becomes thicker than its limb.
      const double radius = (0.4 + 0.6 * size) * 0.5 * roots_.diameter_m;
      prop(base.at, {base.at.x, base.at.y, 0.0}, radius, std::min(radius, thickest), bend);
      merge_into_prop(base.at, radius, size, bend);
    } else if (options_.wood_order >= kAllOrders) {
      constexpr double kThinnest = 0.004;
      const double radius = std::max(kThinnest, (0.1 + 0.15 * size) * thickest);
      hanging(base, radius, (0.1 + 0.45 * size * size) * base.at.z, bend);
    }
  }

 private:
  /// A section of an upright tube.
  static Ring ring(Point at, double radius_m, double along_m, double up) {
    return {.at = at,
            .radius_m = radius_m,
            .tangent = {0.0, 0.0, up},
            .sideways = {1.0, 0.0, 0.0},
            .upward = {0.0, up, 0.0},
            .along_m = along_m};
  }

  /// Thinner roots beside a prop that leave it on their way down: two of three props have them.
  void merge_into_prop(Point top, double radius_m, double size, double bend) {
    const int strands = static_cast<int>(3.0 * size);
    for (int k = 0; k < strands; ++k) {
      const double turn = kTwoPi * (bend + 0.4 * k);
      const double away_m = radius_m * (3.0 + k);
      const Point foot{top.x + away_m * std::sin(turn), top.y + away_m * std::cos(turn), 0.0};
      const double share = 0.85 - 0.3 * k;
      Point fork = top + bow(share, top.z, bend);
      fork.z = share * top.z;
      prop(fork, foot, 0.5 * radius_m, 0.3 * radius_m, -bend);
    }
  }

  /// How far a root bows, which it does not at its ends.
  static Point bow(double share, double length_m, double bend) {
    constexpr double kSway = 0.035;
    const double most_m = kSway * length_m * 4.0 * share * (1.0 - share);
    return {most_m * bend, most_m * (1.0 - std::abs(bend)), 0.0};
  }

  /// From the ground up into the wood at its top.
  void prop(Point top, Point foot, double radius_m, double top_radius_m, double bend) {
    rings_.clear();
    for (const auto& [share, wider] : kProp) {
      const Point at = foot + share * (top - foot) + bow(share, top.z, bend);
      rings_.push_back(
          ring(at, wider * std::lerp(radius_m, top_radius_m, share), share * top.z, 1.0));
    }
    add_tube(rings_, of_prop_, {.textured = options_.textured}, build_);
  }

  /// Down from the limb, ending in a point.
  void hanging(const SkeletonPoint& base, double radius_m, double length_m, double bend) {
    constexpr double kSway = 0.03;
    rings_.clear();
    for (const auto& [share, narrower] : kHanging) {
      Point at = base.at;
      at.x += kSway * length_m * bend * share;
      at.z -= share * length_m;
      rings_.push_back(ring(at, narrower * radius_m, share * length_m, -1.0));
    }
    add_tube(rings_, of_root_, {.textured = options_.textured}, build_);
  }

  const AerialRoots& roots_;
  const MeshOptions& options_;
  std::vector<Point> of_prop_;
  std::vector<Point> of_root_;
  std::vector<Ring> rings_{};
  PartBuilder& build_;
};

}  // namespace

void add_aerial_roots(const Skeleton& skeleton,
                      const Limbs& limbs,
                      const AerialRoots& roots,
                      Random& random,
                      const MeshOptions& options,
                      PartBuilder& build) {
  RootWriter writer(roots, options, build);
  const double stem_radius_m = skeleton.points.front().radius_m;
  for (std::uint32_t i = 1; i < skeleton.axes.size(); ++i) {
    Jitter jitter(random);
    along_limb(
        skeleton.points_of(skeleton.axes[i]), roots.spacing_m, jitter, [&](SkeletonPoint base) {
          base.at = base.at + limbs.moved(i, base.at);
          writer.add(base, stem_radius_m, jitter);
        });
  }
}

}  // namespace silvafit::tree
