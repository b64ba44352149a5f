// SPDX-License-Identifier: MIT
#include "fitted/fitted_stem.hpp"

#include <algorithm>
#include <cmath>

#include "fitted/skeleton_line.hpp"
#include "morphology/breast_height.hpp"

namespace silvafit::tree {
std::vector<SkeletonPoint> fitted_stem(const StandingSkeleton& grown,
                                       const CrownMap& map,
                                       const TreeShape& shape,
                                       const Crown& crown,
                                       const Taper& taper) {
  const std::vector<double> heights = section_heights_m(shape.h_m);
  const std::vector<double> radii = taper.radii_m(heights, shape.h_m, shape.dbh_cm);
  // The height of a section; the stem is on the axis below.
  const double from =
      *std::lower_bound(heights.begin(), heights.end(), std::max(kBreastHeight, shape.hcb_m));
  const double scale = 0.5 * shape.radii.width_m() / map.widest();
  const Point lowest = at_height(grown.course, map.grown_height(from)).at;
  const Point highest = at_height(grown.course, map.grown_height(shape.h_m)).at;

  const auto bent = [&](double z_m) -> Point {
    if (z_m <= from || z_m >= shape.h_m) return {0.0, 0.0, z_m};
    const double share = (z_m - from) / (shape.h_m - from);
    const Point grown_at = at_height(grown.course, map.grown_height(z_m)).at;
    // Both ends stay on the axis.
    const Point chord = lowest + share * (highest - lowest);
    const double x = scale * (grown_at.x - chord.x);
    const double y = scale * (grown_at.y - chord.y);
    const double away = std::hypot(x, y);
    // The inner third of the crown, and no steeper bend than a short crown allows.
    constexpr double kInner = 1.0 / 3.0;
    constexpr double kSteepest = 0.2;
    const double most = std::min(kInner * shape.radii.narrowest_m() * crown.relative_width(z_m),
                                 kSteepest * (shape.h_m - from) * 4.0 * share * (1.0 - share));
    const double kept = away > 0.0 ? most / (most + away) : 0.0;
    return {kept * x, kept * y, z_m};
  };

  std::vector<SkeletonPoint> stem;
  stem.reserve(heights.size());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    stem.push_back({bent(heights[i]), radii[i]});
  }
  return stem;
}

}  // namespace silvafit::tree
