// SPDX-License-Identifier: MIT
#include "mesh/wood_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace silvafit::tree {
namespace {

/// Distance of a regular polygon's outline from its center, in the direction at `angle` from a
/// corner.
double outline(const DrawnTube& tube, double angle) {
  const double step = 2.0 * std::numbers::pi / tube.sides;
  const double from_corner = angle - step * std::floor(angle / step);
  return tube.corner * std::cos(0.5 * step) / std::cos(from_corner - 0.5 * step);
}

/// Largest distance, measured from the center, between the outlines of two polygons with a common
/// corner direction, for radius 1.
double outline_gap(const DrawnTube& a, const DrawnTube& b) {
  constexpr int kDirections = 720;
  double gap = 0.0;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kDirections;
    gap = std::max(gap, std::abs(outline(a, angle) - outline(b, angle)));
  }
  // Between two of the directions the outline changes by less than half a degree of its length.
  return gap + 0.005 * gap;
}

class WoodError {
 public:
  double between(const DrawnTube& finest, const DrawnTube& coarse) {
    corner_ = std::max(finest.corner, coarse.corner);
    gap_ = gap_of(finest, coarse);
    return std::max(farthest(finest.rings, coarse.rings), farthest(coarse.rings, finest.rings));
  }

 private:
  /// Most tubes have the numbers of sides of the one before.
  double gap_of(const DrawnTube& finest, const DrawnTube& coarse) {
    if (finest.sides == coarse.sides) return 0.0;
    if (finest.sides != gap_finest_ || coarse.sides != gap_coarse_ || corner_ != gap_corner_) {
      gap_finest_ = finest.sides;
      gap_coarse_ = coarse.sides;
      gap_corner_ = corner_;
      known_gap_ = outline_gap(finest, coarse);
    }
    return known_gap_;
  }

  double farthest(std::span<const Ring> from, std::span<const Ring> to) const {
    double worst = 0.0;
    std::size_t piece = 0;
    for (const Ring& ring : from) {
      while (piece + 2 < to.size() && to[piece + 1].along_m < ring.along_m) ++piece;
      worst = std::max(worst, error_at(ring, to[piece], to[piece + 1]));
    }
    return worst;
  }

  double error_at(const Ring& ring, const Ring& a, const Ring& b) const {
    const auto [middle, sideways, upward] = offset_between(a, b, ring);
    const double thickest = std::max({ring.radius_m, a.radius_m, b.radius_m});
    // The faces between two inclined rings are not planar, and their diagonals cut the corner: by
    // up to a quarter of the difference of the polygon's sides.
    constexpr double kWarp = 0.25;
    const double turn = length(a.sideways - b.sideways) + length(a.upward - b.upward);
    return length(middle) + corner_ * std::sqrt(dot(sideways, sideways) + dot(upward, upward)) +
           gap_ * thickest + kWarp * corner_ * turn * thickest;
  }

  double corner_ = 1.0;
  double gap_ = 0.0;
  int gap_finest_ = 0;
  int gap_coarse_ = 0;
  double gap_corner_ = 0.0;
  double known_gap_ = 0.0;
};

}  // namespace

double wood_error_m(std::size_t tubes,
                    const TubeOf& finest,
                    const TubeOf& coarse,
                    const std::function<double(std::size_t)>& left_out) {
  WoodError error;
  double worst = 0.0;
  for (std::size_t i = 0; i < tubes; ++i) {
    const DrawnTube kept = coarse(i);
    if (kept.rings.size() < 2) {
      worst = std::max(worst, left_out(i));
      continue;
    }
    const DrawnTube whole = finest(i);
    if (whole.rings.size() > 1) worst = std::max(worst, error.between(whole, kept));
  }
  return worst;
}

}  // namespace silvafit::tree
