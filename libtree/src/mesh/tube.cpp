// SPDX-License-Identifier: MIT
#include "mesh/tube.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/moving_frame.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {

void Ring::turn(Point along, Point aside) {
  tangent = along;
  sideways = square_to(along, aside);
  upward = cross(tangent, sideways);
}

RingOffset offset_between(const Ring& a, const Ring& b, const Ring& ring) {
  const double whole = b.along_m - a.along_m;
  const double part = whole > 0.0 ? std::clamp((ring.along_m - a.along_m) / whole, 0.0, 1.0) : 0.0;
  const auto between = [part](Point from, Point to) { return from + part * (to - from); };
  return {ring.at - between(a.at, b.at),
          ring.radius_m * ring.sideways - between(a.radius_m * a.sideways, b.radius_m * b.sideways),
          ring.radius_m * ring.upward - between(a.radius_m * a.upward, b.radius_m * b.upward)};
}

std::vector<Point> equal_area_corners(int sides) {
  std::vector<Point> result = corners(sides);
  const double enlarged = equal_area_corner(sides);
  for (Point& corner : result) corner = enlarged * corner;
  return result;
}

std::vector<Ring> with_root_sections(std::span<const Ring> sections, const RootFlare& roots) {
  // Rings that floats can distinguish.
  constexpr double kNearest = 0.002;
  std::vector<Ring> result;
  std::size_t next = 0;
  for (std::size_t k = 0; k + 1 < sections.size(); ++k) {
    const Ring& low = sections[k];
    const Ring& high = sections[k + 1];
    result.push_back(low);
    for (; next < RootFlare::kSections.size(); ++next) {
      const double z = RootFlare::kSections[next] * roots.height_m();
      if (z > high.at.z - kNearest) break;
      if (z < result.back().at.z + kNearest) continue;
      const double part = (z - low.at.z) / (high.at.z - low.at.z);
      Ring section = low;
      section.at = low.at + part * (high.at - low.at);
      section.radius_m = low.radius_m + part * (high.radius_m - low.radius_m);
      section.along_m = low.along_m + part * (high.along_m - low.along_m);
      result.push_back(section);
    }
  }
  result.push_back(sections.back());
  return result;
}

namespace {

/// Of a section at a corner.
double radius_m(const Ring& ring, std::uint32_t i, std::uint32_t sides, const TubeLook& look) {
  if (!look.roots) return ring.radius_m;
  return ring.radius_m * look.roots->at(ring.at.z, kTwoPi * (i % sides) / sides);
}

/// Decrease of the radius at a ring, per length. A base that widens inside its parent is not
/// visible.
double lean_of(std::span<const Ring> rings, std::size_t k) {
  const bool widens = k > 0 && rings[k - 1].radius_m < rings[k].radius_m;
  const Ring& before = k > 0 && !widens ? rings[k - 1] : rings[k];
  const Ring& after = rings[k + 1];
  return (before.radius_m - after.radius_m) / std::max(length(after.at - before.at), 1e-9);
}

void add_foot(const Ring& ring,
              std::span<const Point> corners,
              const TubeLook& look,
              PartBuilder& build) {
  const auto sides = static_cast<std::uint32_t>(corners.size());
  const std::uint32_t base = build.vertex_count();
  build.paint(ring.radius_m);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const Point& corner = corners[i];
    build.vertex(ring.at + radius_m(ring, i, sides, look) * ring.across(corner),
                 -1.0 * ring.tangent);
    if (look.textured) {
      const Point flat = direction(corner);
      build.texture({.u = 0.5 + 0.5 * flat.x, .v = 0.5 + 0.5 * flat.y, .tangent = ring.sideways});
    }
  }
  build.close(base, sides);
}

}  // namespace

void add_tube(std::span<const Ring> rings,
              std::span<const Point> corners,
              const TubeLook& look,
              PartBuilder& build) {
  const auto sides = static_cast<std::uint32_t>(corners.size());
  const bool seam = look.textured && has_seam(sides);
  const std::uint32_t around = seam ? sides + 1 : sides;
  build.reserve((rings.size() + 1) * around + 1, (2 * rings.size() + 1) * sides);
  const BarkScale scale =
      build.bark_scale(look.bark_radius_m > 0.0 ? look.bark_radius_m
                                                : std::max(rings[0].radius_m, rings[1].radius_m));
  const double per_corner = 1.0 / length(corners[0]);
  std::uint32_t lower = 0;
  for (std::size_t k = 0; k + 1 < rings.size(); ++k) {
    const Ring& ring = rings[k];
    const double lean = lean_of(rings, k);
    const double upright = 1.0 / std::sqrt(1.0 + lean * lean);
    build.paint(ring.radius_m);
    const std::uint32_t first = build.vertex_count();
    for (std::uint32_t i = 0; i < around; ++i) {
      const Point& corner = corners[i < sides ? i : 0];
      const Point outward = ring.across(corner);
      const double radius = radius_m(ring, i, sides, look);
      Point normal = (upright * per_corner) * outward + (upright * lean) * ring.tangent;
      if (look.roots && k + 2 < rings.size()) {
        const Ring& next = rings[k + 1];
        const double slope =
            (radius - radius_m(next, i, sides, look)) / std::max(length(next.at - ring.at), 1e-9);
        const double size = 1.0 / std::sqrt(1.0 + slope * slope);
        normal = (size * per_corner) * outward + (size * slope) * ring.tangent;
      }
      build.vertex(ring.at + radius * outward, normal);
      if (look.textured) {
        const Point flat = per_corner * corner;
        build.texture({.u = scale.u(static_cast<double>(i) / sides, ring.along_m),
                       .v = -scale.per_m * ring.along_m,
                       .tangent = flat.x * ring.upward - flat.y * ring.sideways});
      }
    }
    if (k > 0) {
      build.join(lower, first, sides, seam);
    } else if (!look.has_foot && !look.is_open) {
      build.close(first, sides);
    }
    lower = first;
  }
  const Ring& last = rings[rings.size() - 2];
  const Ring& tip = rings.back();
  const std::uint32_t end = build.vertex(tip.at, direction(tip.at - last.at, last.tangent));
  if (look.textured) {
    build.texture({.u = scale.u(0.5, tip.along_m),
                   .v = -scale.per_m * tip.along_m,
                   .tangent = last.sideways});
  }
  build.join_to_tip(lower, end, sides, seam);
  if (look.has_foot) add_foot(rings.front(), corners, look, build);
}

bool RingInCrown::contains(Point at, double radius_m) const {
  return std::ranges::all_of(corners_, [&](const Point& corner) {
    return crown_.contains(at + radius_m * across(corner));
  });
}

/// Of the corners of a ring of radius 1, relative to its center.
double RingInCrown::lowest() const {
  double lowest = 0.0;
  for (const Point& corner : corners_) lowest = std::min(lowest, across(corner).z);
  return lowest;
}

/// Near a direction in which the crown is much narrower, a tiny change of azimuth matters.
bool RingInCrown::move_inward(Point& at, double radius_m, double step_m) const {
  constexpr int kMostSteps = 12;
  for (int i = 1; i <= kMostSteps && !contains(at, radius_m); ++i) {
    const double away = std::hypot(at.x, at.y);
    const double nearer = std::max(away - step_m * i, 0.0) / std::max(away, step_m);
    at = crown_.confine({nearer * at.x, nearer * at.y, at.z});
  }
  return contains(at, radius_m);
}

bool RingInCrown::fit(Point& at, double& radius_m, double let_pass_m) const {
  if (contains(at, radius_m)) return true;
  const double low = lowest();
  const double missing = crown_.hcb_m() - (at.z + radius_m * low);
  if (missing > 0.0) at.z += missing;
  at = crown_.confine(at);
  constexpr double kShrink = 0.75;
  while (!contains(at, radius_m)) {
    if (radius_m <= let_pass_m) return move_inward(at, radius_m, let_pass_m);
    const double smaller = std::max(kShrink * radius_m, 0.99 * let_pass_m);
    if (missing > 0.0) {
      at.z += (radius_m - smaller) * low;
      at = crown_.confine(at);
    }
    radius_m = smaller;
  }
  return true;
}

}  // namespace silvafit::tree
