// SPDX-License-Identifier: MIT
#include "mesh/level_of_detail.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mesh/bark_surface.hpp"
#include "mesh/polygon.hpp"
#include "mesh/tube.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

struct Level {
  int stem_sides;
  int branch_sides;
  double stem_tolerance_m;
  double branch_tolerance_m;
  int wood_order;
  int foliage_per;
};

constexpr std::array<Level, kLevelsOfDetail> kLevels{{
    {12, 6, 0.0005, 0.0, kAllOrders, 1},
    {8, 4, 0.002, 0.005, 6, 2},
    {6, 3, 0.01, 0.03, 3, 4},
    {4, 3, 0.03, 0.2, 1, 8},
}};

/// Distance of a regular polygon's outline from its center, in the direction at `angle` from a
/// corner.
double outline(int sides, double corner, double angle) {
  const double step = 2.0 * std::numbers::pi / sides;
  const double from_corner = angle - step * std::floor(angle / step);
  return corner * std::cos(0.5 * step) / std::cos(from_corner - 0.5 * step);
}

/// Largest distance, measured from the center, between the outlines of two polygons with a common
/// corner direction; both have the area of the unit circle.
double outline_gap(int sides, double corner, int other_sides, double other_corner) {
  constexpr int kDirections = 720;
  double gap = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kDirections;
    gap = std::max(
        gap, std::abs(outline(sides, corner, angle) - outline(other_sides, other_corner, angle)));
  }
  // Between two of the directions the outline changes by less than half a degree of its length.
  return gap + 0.005 * gap;
}

/// Distances from the finest level's outlines for the numbers of sides of the levels, computed
/// once.
struct OutlineGaps {
  static constexpr int kMost = 16;
  std::array<double, kMost + 1> stem{};
  std::array<double, kMost + 1> branch{};
};

const OutlineGaps& gaps_to_finest() {
  static const OutlineGaps gaps = [] {
    OutlineGaps result;
    for (int sides = 3; sides <= OutlineGaps::kMost; ++sides) {
      const auto at = static_cast<std::size_t>(sides);
      result.stem[at] = equal_area_gap(sides, kLevels[0].stem_sides);
      result.branch[at] = outline_gap(sides, 1.0, kLevels[0].branch_sides, 1.0);
    }
    return result;
  }();
  return gaps;
}

/// Error of a tube at a point of the whole axis, relative to the piece between two points that it
/// keeps; `gap` is that of the sections' outlines, `corner` the distance of their corners.
double error_at(const SkeletonPoint& at,
                const SkeletonPoint& from,
                const SkeletonPoint& to,
                double gap,
                double corner) {
  const Point chord = to.at - from.at;
  const double squared = dot(chord, chord);
  const double part =
      squared > 0.0 ? std::clamp(dot(at.at - from.at, chord) / squared, 0.0, 1.0) : 0.0;
  const double radius = from.radius_m + part * (to.radius_m - from.radius_m);
  return length(at.at - (from.at + part * chord)) + corner * std::abs(at.radius_m - radius) +
         gap * std::max(at.radius_m, radius);
}

/// The same for all pieces of a tube.
double least_error_at(const SkeletonPoint& at,
                      std::span<const SkeletonPoint> kept,
                      double gap,
                      double corner) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < kept.size(); ++i) {
    least = std::min(least, error_at(at, kept[i], kept[i + 1], gap, corner));
  }
  return least;
}

class ErrorBound {
 public:
  ErrorBound(const Skeleton& skeleton, const Crown& crown, const MeshOptions& options)
      : skeleton_(skeleton),
        crown_(crown),
        options_(options),
        finest_(level_of_detail(0, options)) {}

  double bound() {
    double worst = 0.0;
    for (const Axis& axis : skeleton_.axes) {
      const auto points = skeleton_.points_of(axis);
      if (axis.order == 0) {
        worst = std::max(worst, of_stem(points));
      } else if (is_drawn(axis, points.front(), options_)) {
        worst = std::max(worst, of_branch(points, bearer_radius_m(skeleton_, axis)));
      } else if (is_drawn(axis, points.front(), finest_)) {
        worst = std::max(worst, of_left_out(axis, points));
      }
    }
    return worst;
  }

 private:
  double of_stem(std::span<const SkeletonPoint> points) {
    if (options_.stem_sides == finest_.stem_sides &&
        options_.stem_tolerance_m == finest_.stem_tolerance_m) {
      return 0.0;
    }
    const double corner =
        std::max(equal_area_corner(options_.stem_sides), equal_area_corner(finest_.stem_sides));
    const double gap = options_.stem_sides <= OutlineGaps::kMost
                           ? gaps_to_finest().stem[static_cast<std::size_t>(options_.stem_sides)]
                           : equal_area_gap(options_.stem_sides, finest_.stem_sides);
    needed_sections(points, stem_tolerance_m(options_), kept_);
    double worst = 0.0;
    std::size_t piece = 0;
    for (const SkeletonPoint& at : points) {
      while (piece + 2 < kept_.size() && kept_[piece + 1].at.z < at.at.z) ++piece;
      worst = std::max(worst, error_at(at, kept_[piece], kept_[piece + 1], gap, corner));
    }
    // Roots make the sections wider.
    if (options_.textured) worst *= RootFlare::kWidest;
    // The finest level has also omitted points.
    return worst + std::max(corner, kBendTolerance) * stem_tolerance_m(finest_);
  }

  static double branch_gap(int sides, int finest) {
    if (sides == finest) return 0.0;
    const bool is_listed = finest == kLevels[0].branch_sides && sides <= OutlineGaps::kMost;
    return is_listed ? gaps_to_finest().branch[static_cast<std::size_t>(sides)]
                     : outline_gap(sides, 1.0, finest, 1.0);
  }

  double of_branch(std::span<const SkeletonPoint> points, double bearer) {
    const int sides = sides_of(points.front(), options_);
    const int finest = sides_of(points.front(), finest_);
    if (sides == finest && options_.branch_tolerance_m == 0.0) return 0.0;
    const double gap = branch_gap(sides, finest);
    const TubeFrame frame = frame_of(points);
    branch_rings(points, branch_tolerance_m(options_), frame, sides, bearer, crown_, kept_);
    branch_rings(points, branch_tolerance_m(finest_), frame, finest, bearer, crown_, whole_);
    if (whole_.size() < 2) return 0.0;
    if (kept_.size() < 2) return length(whole_.back().at - whole_.front().at);
    double worst = 0.0;
    for (const SkeletonPoint& at : whole_) {
      worst = std::max(worst, least_error_at(at, kept_, gap, 1.0));
    }
    return worst;
  }

  /// The error of a twig that is not drawn is its distance from its parent axis.
  double of_left_out(const Axis& axis, std::span<const SkeletonPoint> points) {
    const Axis* bearer = &skeleton_.axes[axis.parent];
    while (bearer->order > 0 &&
           !is_drawn(*bearer, skeleton_.points_of(*bearer).front(), options_)) {
      bearer = &skeleton_.axes[bearer->parent];
    }
    const auto drawn = skeleton_.points_of(*bearer);
    if (bearer->order == 0) {
      kept_.assign(drawn.begin(), drawn.end());
    } else {
      needed_points(drawn, branch_tolerance_m(options_), kept_);
    }
    double worst = 0.0;
    for (const SkeletonPoint& at : points) {
      const double least = least_error_at({at.at, 0.0}, kept_, 0.0, 0.0);
      worst = std::max(worst, least + at.radius_m);
    }
    return worst;
  }

  const Skeleton& skeleton_;
  const Crown& crown_;
  const MeshOptions& options_;
  MeshOptions finest_;
  std::vector<SkeletonPoint> kept_;   ///< the points of the tube
  std::vector<SkeletonPoint> whole_;  ///< the same for the finest level
};

}  // namespace

double equal_area_gap(int sides, int other_sides) {
  return outline_gap(sides, equal_area_corner(sides), other_sides, equal_area_corner(other_sides));
}

MeshOptions level_of_detail(int level, const MeshOptions& base) {
  if (level < 0 || level >= kLevelsOfDetail) {
    throw UsageError("a level of detail must be from 0 (finest) to " +
                     std::to_string(kLevelsOfDetail - 1) + ", not " + std::to_string(level));
  }
  const Level& of = kLevels[static_cast<std::size_t>(level)];
  MeshOptions options = base;
  options.stem_sides = of.stem_sides;
  options.branch_sides = of.branch_sides;
  options.twig_sides = 3;
  options.thick_branch_m = MeshOptions{}.thick_branch_m;
  options.stem_tolerance_m = of.stem_tolerance_m;
  options.branch_tolerance_m = of.branch_tolerance_m;
  options.wood_order = of.wood_order;
  options.foliage_per = of.foliage_per;
  return options;
}

double surface_error_m(const Skeleton& skeleton, const Crown& crown, const MeshOptions& options) {
  return ErrorBound(skeleton, crown, options).bound();
}

}  // namespace silvafit::tree
