// SPDX-License-Identifier: MIT
#include "mesh/tube.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/bark_surface.hpp"
#include "mesh/level_of_detail.hpp"
#include "mesh/line_simplification.hpp"
#include "mesh/polygon.hpp"
#include "mesh/ring_in_crown.hpp"
#include "morphology/breast_height.hpp"
#include "silvafit/base/constants.hpp"

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

/// The tube of an upright stem, with roots if it has a texture.
class StemTube {
 public:
  StemTube(std::span<const SkeletonPoint> sections, const MeshOptions& options, PartBuilder& build)
      : sections_(sections),
        sides_(static_cast<std::uint32_t>(options.stem_sides)),
        seam_(options.textured),
        polygon_(corners(options.stem_sides)),
        enlarged_(equal_area_corner(options.stem_sides)),
        scale_(build.bark_scale(sections.front().radius_m)),
        flare_(sections.front().radius_m),
        build_(build) {}

  void add() {
    build_.reserve((sections_.size() + 2) * (sides_ + 2), (2 * sections_.size() + 1) * sides_);
    add_wall();
    add_foot();
  }

 private:
  void add_wall() {
    std::uint32_t ring = 0;
    for (std::size_t k = 0; k + 1 < sections_.size(); ++k) {
      const std::uint32_t first = add_ring(sections_[k], sections_[k + 1]);
      if (k > 0) build_.join(ring, first, sides_, seam_);
      ring = first;
    }
    const SkeletonPoint& end = sections_.back();
    build_.paint(end.radius_m);
    const std::uint32_t tip = build_.vertex(end.at, {0.0, 0.0, 1.0});
    texture(0, end.at.z);
    build_.join_to_tip(ring, tip, sides_, seam_);
  }

  /// \returns the ring's first vertex
  std::uint32_t add_ring(const SkeletonPoint& here, const SkeletonPoint& next) {
    build_.paint(here.radius_m);
    const std::uint32_t first = build_.vertex_count();
    const std::uint32_t around = seam_ ? sides_ + 1 : sides_;
    for (std::uint32_t i = 0; i < around; ++i) {
      const Point& corner = polygon_[i % sides_];
      const double radius = radius_m(here, i);
      const double slope = (radius - radius_m(next, i)) / (next.at.z - here.at.z);
      const double scale = 1.0 / std::sqrt(1.0 + slope * slope);
      build_.vertex(here.at + enlarged_ * radius * corner,
                    {scale * corner.x, scale * corner.y, scale * slope});
      texture(i, here.at.z);
    }
    return first;
  }

  /// Of a section at a corner.
  double radius_m(const SkeletonPoint& section, std::uint32_t i) const {
    if (!seam_) return section.radius_m;
    return section.radius_m * flare_.at(section.at.z, kTwoPi * (i % sides_) / sides_);
  }

  void texture(std::uint32_t i, double height_m) {
    if (!seam_) return;
    const Point& corner = polygon_[i % sides_];
    build_.texture({.u = scale_.u(static_cast<double>(i) / sides_, height_m),
                    .v = -height_m * scale_.per_m,
                    .tangent = {-corner.y, corner.x, 0.0}});
  }

  /// Closes the tube at the ground.
  void add_foot() {
    const SkeletonPoint& foot = sections_.front();
    build_.paint(foot.radius_m);
    const std::uint32_t base = build_.vertex_count();
    for (std::uint32_t i = 0; i < sides_; ++i) {
      const Point& corner = polygon_[i];
      build_.vertex(foot.at + enlarged_ * radius_m(foot, i) * corner, {0.0, 0.0, -1.0});
      if (seam_) {
        build_.texture(
            {.u = 0.5 + 0.5 * corner.x, .v = 0.5 + 0.5 * corner.y, .tangent = {1.0, 0.0, 0.0}});
      }
    }
    build_.close(base, sides_);
  }

  std::span<const SkeletonPoint> sections_;
  std::uint32_t sides_;
  bool seam_;
  std::vector<Point> polygon_;
  double enlarged_;  ///< the section's corners, so that its area is that of the circle
  BarkScale scale_;
  RootFlare flare_;
  PartBuilder& build_;
};

/// Wood at the base of a branch that widens into its parent, instead of a cylinder through it;
/// nothing if the crown has no space for it.
/// \param bearer_radius_m  0 for none
void add_collar(std::vector<SkeletonPoint>& rings,
                const TubeFrame& frame,
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

}  // namespace

TubeFrame frame_of(std::span<const SkeletonPoint> branch) {
  // Branches bend so little that one frame is enough for a whole branch.
  const Point tangent = direction(branch.back().at - branch.front().at);
  const Point sideways = direction(cross({0.0, 0.0, 1.0}, tangent), {1.0, 0.0, 0.0});
  return {tangent, sideways, cross(tangent, sideways)};
}

void branch_rings(std::span<const SkeletonPoint> branch,
                  double tolerance_m,
                  const TubeFrame& frame,
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

void needed_sections(std::span<const SkeletonPoint> stem,
                     double tolerance_m,
                     std::vector<SkeletonPoint>& sections) {
  std::vector<bool> needed(stem.size(), tolerance_m == 0.0);
  const TubeError error{.bend = 1.0 / kBendTolerance};
  std::size_t from = 0;
  needed.front() = needed.back() = true;
  if (tolerance_m > 0.0) {
    for (std::size_t i = 1; i + 1 < stem.size(); ++i) {
      if (stem[i].at.z != kBreastHeight) continue;
      needed[i] = true;
      mark_needed(stem, 0, i, tolerance_m, error, needed);
      from = i;
    }
    mark_needed(stem, from, stem.size() - 1, tolerance_m, error, needed);
  }
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

void needed_points(std::span<const SkeletonPoint> branch,
                   double tolerance_m,
                   std::vector<SkeletonPoint>& needed) {
  if (tolerance_m == 0.0 || branch.size() == 2) {
    needed.assign(branch.begin(), branch.end());
    return;
  }
  std::vector<bool> marks(branch.size(), false);
  marks.front() = marks.back() = true;
  mark_needed(branch, 0, branch.size() - 1, tolerance_m, TubeError{}, marks);
  take_marked(branch, marks, needed);
}

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

void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build) {
  std::vector<SkeletonPoint> sections;
  needed_sections(stem, stem_tolerance_m(options), sections);
  if (options.textured) {
    sections = with_root_sections<SkeletonPoint>(sections, RootFlare(sections.front().radius_m));
  }
  StemTube(sections, options, build).add();
}

BranchTubes::BranchTubes(const Crown& crown, const MeshOptions& options, PartBuilder& build)
    : crown_(crown),
      options_(options),
      build_(build),
      branch_polygon_(corners(options.branch_sides)),
      twig_polygon_(corners(options.twig_sides)) {}

void BranchTubes::reserve(const Skeleton& skeleton) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const Axis& axis : skeleton.axes) {
    const SkeletonPoint& base = skeleton.points[axis.first];
    if (axis.order == 0 || !is_drawn(axis, base, options_)) continue;
    const auto around = static_cast<std::size_t>(sides_of(base, options_));
    // Two rings more for a collar.
    vertices += (axis.count + 2) * (around + 1) + 1;
    triangles += (2 * axis.count + 5) * around;
  }
  build_.reserve(vertices, triangles);
}

void BranchTubes::add_ring(const SkeletonPoint& ring,
                           const TubeFrame& frame,
                           const std::vector<Point>& polygon,
                           const BarkScale& scale,
                           double along_m,
                           double lean) {
  const std::size_t sides = polygon.size();
  const bool seam = options_.textured && has_seam(static_cast<std::uint32_t>(sides));
  const std::size_t around = sides + (seam ? 1 : 0);
  const double upright = 1.0 / std::sqrt(1.0 + lean * lean);
  build_.paint(ring.radius_m);
  for (std::size_t i = 0; i < around; ++i) {
    const Point& corner = polygon[i % sides];
    const Point outward = frame.across(corner);
    build_.vertex(ring.at + ring.radius_m * outward, upright * (outward + lean * frame.tangent));
    if (options_.textured) {
      build_.texture({.u = scale.u(static_cast<double>(i) / static_cast<double>(sides), along_m),
                      .v = -along_m * scale.per_m,
                      .tangent = corner.x * frame.upward - corner.y * frame.sideways});
    }
  }
}

void BranchTubes::add(std::span<const SkeletonPoint> branch, double bearer_radius_m) {
  const bool is_thick = sides_of(branch.front(), options_) == options_.branch_sides;
  const std::vector<Point>& polygon = is_thick ? branch_polygon_ : twig_polygon_;
  const auto sides = static_cast<std::uint32_t>(polygon.size());
  const bool seam = options_.textured && has_seam(sides);
  const TubeFrame frame = frame_of(branch);
  branch_rings(branch,
               branch_tolerance_m(options_),
               frame,
               static_cast<int>(sides),
               bearer_radius_m,
               crown_,
               points_);
  if (points_.size() < 2) return;
  const double reach = length(points_.back().at - points_.front().at);
  build_.reserve(points_.size() * (sides + 1) + 1, (2 * points_.size() + 1) * sides);

  const double lean = points_.front().radius_m / reach;
  const BarkScale scale = build_.bark_scale(branch.front().radius_m);
  std::uint32_t ring = 0;
  for (std::size_t k = 0; k + 1 < points_.size(); ++k) {
    const std::uint32_t first = build_.vertex_count();
    const double along_m = dot(points_[k].at - points_.front().at, frame.tangent);
    add_ring(points_[k], frame, polygon, scale, along_m, lean);
    if (k > 0) {
      build_.join(ring, first, sides, seam);
    } else if (options_.closed_branches) {
      build_.close(first, sides);
    }
    ring = first;
  }
  build_.paint(points_.back().radius_m);
  const std::uint32_t tip = build_.vertex(points_.back().at, frame.tangent);
  if (options_.textured) {
    build_.texture(
        {.u = scale.u(0.5, reach), .v = -reach * scale.per_m, .tangent = frame.sideways});
  }
  build_.join_to_tip(ring, tip, sides, seam);
}

}  // namespace silvafit::tree
