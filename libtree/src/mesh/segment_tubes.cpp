// SPDX-License-Identifier: MIT
#include "mesh/segment_tubes.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/level_of_detail.hpp"
#include "mesh/line_simplification.hpp"
#include "mesh/tube.hpp"
#include "mesh/wood_error.hpp"
#include "segments/skeleton_line.hpp"

namespace silvafit::tree {
namespace {

/// Error of the surface at a point that is omitted between two others: its radius and its center
/// together.
struct TubeError {
  double bend = 1.0;  ///< weight of the center's error

  double operator()(const SkeletonPoint& a, const SkeletonPoint& b, const SkeletonPoint& at) const {
    const Point chord = b.at - a.at;
    const double squared = dot(chord, chord);
    const double part = squared > 0.0 ? dot(at.at - a.at, chord) / squared : 0.0;
    return std::abs(at.radius_m - (a.radius_m + part * (b.radius_m - a.radius_m))) +
           bend * length(at.at - (a.at + part * chord));
  }
};

/// The points of the stem that are needed for errors of at most the tolerance for its radius, and
/// kBendTolerance times that for its axis; always the ends and breast height.
void needed_sections(std::span<const SkeletonPoint> stem,
                     double tolerance_m,
                     std::vector<SkeletonPoint>& sections) {
  std::vector<bool> needed =
      needed_of(stem, tolerance_m, TubeError{.bend = 1.0 / kBendTolerance}, [&](const auto& point) {
        return tolerance_m == 0.0 || point.at.z == kBreastHeight;
      });
  // Sections that floats cannot distinguish from the tip.
  constexpr double kThinnest = 0.00005;
  constexpr double kNearest = 0.001;
  const double tip = stem.back().at.z;
  for (std::size_t i = 1; i + 1 < stem.size(); ++i) {
    const bool is_tip = stem[i].radius_m < kThinnest || tip - stem[i].at.z < kNearest;
    if (is_tip && stem[i].at.z != kBreastHeight) needed[i] = false;
  }
  take_marked(stem, needed, sections);
}

/// The same for a branch: its ends, and points where it bends by more than the tolerance.
void needed_points(std::span<const SkeletonPoint> branch,
                   double tolerance_m,
                   std::vector<SkeletonPoint>& needed) {
  if (tolerance_m == 0.0 || branch.size() == 2) {
    needed.assign(branch.begin(), branch.end());
    return;
  }
  const auto never = [](const SkeletonPoint&) { return false; };
  take_marked(branch, needed_of(branch, tolerance_m, TubeError{}, never), needed);
}

/// Radius of the stem where a first-order branch starts; 0 for other axes, which need no collar.
double bearer_radius_m(const Skeleton& skeleton, const Axis& axis) {
  if (axis.order != 1) return 0.0;
  const auto stem = skeleton.points_of(skeleton.axes.front());
  const double z = skeleton.points[axis.first].at.z;
  const auto above =
      std::lower_bound(stem.begin(), stem.end(), z, [](const SkeletonPoint& point, double height) {
        return point.at.z < height;
      });
  return (above == stem.end() ? stem.back() : *above).radius_m;
}

/// Wood at the base of a branch that widens into its parent, instead of a cylinder through it;
/// nothing if the crown has no space for it.
/// \param bearer_radius_m  0 for none
void add_collar(std::vector<SkeletonPoint>& rings,
                const Frame& frame,
                double bearer_radius_m,
                const RingInCrown& in_crown) {
  constexpr double kThinnest = 0.02;
  const double radius = rings.front().radius_m;
  if (bearer_radius_m <= 0.0 || radius < kThinnest || rings.size() < 2) return;
  const double level = std::max(std::hypot(frame.tangent.x, frame.tangent.y), 0.25);
  const double surface = bearer_radius_m / level;
  constexpr double kNear = 0.35;
  constexpr double kFar = 1.9;
  constexpr double kWide = 1.5;
  constexpr double kInside = 0.9;
  const Point base = rings.front().at;
  const Point step = rings[1].at - base;
  const double reach = length(step);
  const double far = surface + kFar * radius;
  if (far > 0.8 * reach) return;
  const auto ring = [&](double along, double wider) {
    const double part = along / reach;
    return SkeletonPoint{base + part * step,
                         wider * (radius + part * (rings[1].radius_m - radius))};
  };
  const double widest = std::min(kWide * radius, std::max(kInside * bearer_radius_m, radius));
  const SkeletonPoint near_ring = ring(surface + kNear * radius, 0.5 * (1.0 + kWide));
  const SkeletonPoint far_ring = ring(far, 1.0);
  if (!in_crown.contains(base, widest) || !in_crown.contains(near_ring.at, near_ring.radius_m) ||
      !in_crown.contains(far_ring.at, far_ring.radius_m)) {
    return;
  }
  rings.front().radius_m = widest;
  rings.insert(rings.begin() + 1, {near_ring, far_ring});
}

/// The rings of a branch's tube and the point at its end. Only the end is left of a branch that is
/// too short for floats. A branch widens into a bearer of this radius; 0 for none.
void branch_rings(std::span<const SkeletonPoint> branch,
                  double tolerance_m,
                  const Frame& frame,
                  int sides,
                  double bearer_radius_m,
                  const Crown& crown,
                  std::vector<SkeletonPoint>& rings) {
  needed_points(branch, tolerance_m, rings);
  // The same polygon at all levels of detail, so that their rings are the same.
  static const std::vector<Point> round = corners(12);
  const bool has_corners = 12 % sides == 0;
  const std::vector<Point> own = has_corners ? std::vector<Point>{} : corners(sides);
  const RingInCrown in_crown(crown, has_corners ? round : own, frame.sideways, frame.upward);
  add_collar(rings, frame, bearer_radius_m, in_crown);
  constexpr double kLetPass = 0.00045;
  // If a crown is flat or thin, rings may be side by side; floats cannot distinguish
  // them.
  const SkeletonPoint tip = rings.back();
  const double apart = 0.0002 * (1.0 + 0.05 * tip.at.z);
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 1 < rings.size(); ++i) {
    SkeletonPoint ring = rings[i];
    in_crown.fit(ring.at, ring.radius_m, kLetPass);
    if (dot(tip.at - ring.at, frame.tangent) < apart) continue;
    if (kept > 0 && dot(ring.at - rings[kept - 1].at, frame.tangent) < apart) continue;
    rings[kept++] = ring;
  }
  rings[kept++] = tip;
  rings.resize(kept);
}

/// Adds rings that all have the same plane.
void add_rings(std::span<const SkeletonPoint> points,
               const Frame& frame,
               std::vector<Ring>& rings) {
  for (const auto& [at, radius_m] : points) {
    rings.push_back({at,
                     radius_m,
                     frame.tangent,
                     frame.sideways,
                     frame.upward,
                     dot(at - points.front().at, frame.tangent)});
  }
}

void add_stem_rings(std::span<const SkeletonPoint> stem,
                    const MeshOptions& options,
                    std::vector<Ring>& rings) {
  std::vector<SkeletonPoint> sections;
  needed_sections(stem, stem_tolerance_m(options), sections);
  add_rings(sections, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, rings);
}

void add_stem_tube(std::span<const Ring> rings, const MeshOptions& options, PartBuilder& build) {
  TubeLook look{
      .textured = options.textured, .has_foot = true, .bark_radius_m = rings.front().radius_m};
  const std::vector<Point> corners = equal_area_corners(options.stem_sides);
  if (!options.textured) return add_tube(rings, corners, look, build);
  look.roots = RootFlare(rings.front().radius_m);
  add_tube(with_root_sections(rings, *look.roots), corners, look, build);
}

}  // namespace

void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build) {
  std::vector<Ring> rings;
  add_stem_rings(stem, options, rings);
  add_stem_tube(rings, options, build);
}

SegmentTubes::SegmentTubes(const Skeleton& skeleton,
                           const Crown& crown,
                           const MeshOptions& options,
                           const SegmentTubes* only)
    : skeleton_(skeleton), crown_(crown), options_(options) {
  first_.reserve(skeleton.axes.size() + 1);
  std::vector<SkeletonPoint> points;
  for (std::size_t i = 0; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    const auto line = skeleton.points_of(axis);
    if (axis.order == 0) {
      add_stem_rings(line, options, rings_);
    } else if (is_drawn(axis, line.front(), options) && (only == nullptr || !only->of(i).empty())) {
      // Branches bend so little that one frame is enough for a whole branch.
      const Frame frame = frame_along(line.back().at - line.front().at);
      const double bearer = bearer_radius_m(skeleton, axis);
      branch_rings(line, branch_tolerance_m(options), frame, sides_of(i), bearer, crown, points);
      if (points.size() > 1) add_rings(points, frame, rings_);
    }
    first_.push_back(rings_.size());
  }
}

int SegmentTubes::sides_of(std::size_t axis) const {
  if (axis == 0) return options_.stem_sides;
  return tree::sides_of(skeleton_.points[skeleton_.axes[axis].first], options_);
}

void SegmentTubes::add_to(PartBuilder& stem, PartBuilder& branches) const {
  add_stem_tube(of(0), options_, stem);
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (std::size_t i = 1; i < skeleton_.axes.size(); ++i) {
    const auto sides = static_cast<std::size_t>(sides_of(i));
    vertices += of(i).size() * (sides + 1);
    triangles += (2 * of(i).size() + 1) * sides;
  }
  branches.reserve(vertices, triangles);
  const std::vector<Point> of_branch = corners(options_.branch_sides);
  const std::vector<Point> of_twig = corners(options_.twig_sides);
  for (std::size_t i = 1; i < skeleton_.axes.size(); ++i) {
    if (of(i).size() < 2) continue;
    add_tube(of(i),
             sides_of(i) == options_.branch_sides ? of_branch : of_twig,
             {.textured = options_.textured,
              .is_open = !options_.closed_branches,
              .bark_radius_m = skeleton_.points[skeleton_.axes[i].first].radius_m},
             branches);
  }
}

double SegmentTubes::surface_error_m() const {
  const MeshOptions finest = level_of_detail(0, options_);
  if (has_same_wood(finest, options_)) return 0.0;
  const SegmentTubes whole(skeleton_, crown_, finest, this);
  const auto tube = [this](const SegmentTubes& tubes, std::size_t i) -> DrawnTube {
    const int sides = tubes.sides_of(i);
    if (i > 0) return {tubes.of(i), sides};
    // Roots make the sections wider.
    const double wider = options_.textured ? RootFlare::kWidest : 1.0;
    return {tubes.of(i), sides, wider * equal_area_corner(sides)};
  };
  std::vector<SkeletonPoint> drawn;
  return wood_error_m(
      skeleton_.axes.size(),
      [&](std::size_t i) { return tube(whole, i); },
      [&](std::size_t i) { return tube(*this, i); },
      [&](std::size_t i) { return left_out_m(i, finest, drawn); });
}

/// The error of a twig that is not drawn is its distance from its parent axis.
double SegmentTubes::left_out_m(std::size_t axis,
                                const MeshOptions& finest,
                                std::vector<SkeletonPoint>& drawn) const {
  const Axis& own = skeleton_.axes[axis];
  if (!is_drawn(own, skeleton_.points[own.first], finest)) return 0.0;
  std::size_t bearer = own.parent;
  while (bearer != 0 && of(bearer).empty()) bearer = skeleton_.axes[bearer].parent;
  needed_points(skeleton_.points_of(skeleton_.axes[bearer]),
                bearer == 0 ? 0.0 : branch_tolerance_m(options_),
                drawn);
  double worst = 0.0;
  for (const auto& [at, radius_m] : skeleton_.points_of(own)) {
    const auto [segment, part] = nearest_place(drawn, at);
    const Point there = between(drawn[segment], drawn[segment + 1], part).at;
    worst = std::max(worst, length(at - there) + radius_m);
  }
  return worst;
}

}  // namespace silvafit::tree
