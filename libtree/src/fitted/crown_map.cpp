// SPDX-License-Identifier: MIT
#include "fitted/crown_map.hpp"

#include <algorithm>
#include <cmath>

namespace silvafit::tree {
namespace {

double level_distance(double x, double y) { return std::sqrt(x * x + y * y); }

constexpr double kBent = 0.04;  // the relative crown depth in which branches are bent

/// The identity except near 0 and 1, which it approaches smoothly from inside and never reaches.
double between_curves(double share) {
  if (share < kBent) return kBent * std::exp((share - kBent) / kBent);
  if (share > 1.0 - kBent) return 1.0 - kBent * std::exp((1.0 - kBent - share) / kBent);
  return share;
}

/// The identity up to the knee; above, smoothly compressed so that `most` becomes 1.
double drawn_in(double out, double most) {
  constexpr double kKnee = 0.7;
  if (out <= kKnee || most <= 1.0) return std::min(out, 1.0);
  const double beyond = (out - kKnee) / (1.0 - kKnee);
  const double longest = (most - kKnee) / (1.0 - kKnee);
  return std::min(kKnee + (1.0 - kKnee) * beyond / (1.0 + (1.0 - 1.0 / longest) * beyond), 1.0);
}

/// A crown's width by height, with a minimum so that branches do not vanish.
double kept_width(const Crown& crown, double z_m) {
  constexpr double kLeast = 0.3;
  const double width = crown.relative_width(z_m);
  return std::sqrt(width * width + kLeast * kLeast * (1.0 - width * width));
}

}  // namespace

CrownMap::CrownMap(const StandingSkeleton& grown, const Crown& crown)
    : crown_(crown), low_(0.0), high_(grown.top) {
  // Parts below the first branch move with it, unless they are far below: then they are bent up.
  constexpr double kHanging = 0.15;
  low_ = std::max(grown.lowest, grown.first_base - kHanging * (high_ - grown.first_base));
  low_ = std::clamp(low_, 0.0, 0.98 * high_);
  match_widest(grown);
  reach_ = silhouette(grown);
  for (std::size_t i = 0; i <= kWidths; ++i) {
    const double share = static_cast<double>(i) / kWidths;
    widths_[i] = kept_width(crown, crown.hcb_m() + share * (crown.h_m() - crown.hcb_m()));
  }
  for (std::size_t i = grown.skeleton.axes.front().count; i < grown.skeleton.points.size(); ++i) {
    const Point at = grown.skeleton.points[i].at;
    outliers_ = std::max(outliers_, level_distance(at.x, at.y) / reach_at(share_of(at.z)));
  }
}

/// Transforms the heights so that the highest of the widest layers is moved to hc.
void CrownMap::match_widest(const StandingSkeleton& grown) {
  const auto widths = silhouette(grown);
  const double most = *std::max_element(widths.begin(), widths.end());
  double weight = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < kLayers; ++i) {
    constexpr double kNearlyWidest = 0.9;
    if (widths[i] < kNearlyWidest * most) continue;
    weight += 1.0;
    sum += (static_cast<double>(i) + 0.5) / kLayers;
  }
  const double widest = sum / weight;
  constexpr double kInside = 0.02;
  const double wanted = std::clamp(
      (crown_.hc_m() - crown_.hcb_m()) / (crown_.h_m() - crown_.hcb_m()), kInside, 1.0 - kInside);
  constexpr double kStrongest = 2.5;
  skew_ =
      std::clamp(widest * (1.0 - wanted) / (wanted * (1.0 - widest)), 1.0 / kStrongest, kStrongest);
}

/// Distance of branches from the axis at each height, smoothed.
std::array<double, CrownMap::kLayers> CrownMap::silhouette(const StandingSkeleton& grown) const {
  std::array<double, kLayers> reach{};
  const Skeleton& skeleton = grown.skeleton;
  const auto layer_of = [this](double z) {
    const double at = std::clamp(share_of(z), 0.0, 1.0) * kLayers;
    return std::min(static_cast<std::size_t>(at), kLayers - 1);
  };
  for (std::size_t a = 1; a < skeleton.axes.size(); ++a) {
    const auto line = skeleton.points_of(skeleton.axes[a]);
    double before = level_distance(line[0].at.x, line[0].at.y);
    std::size_t from = layer_of(line[0].at.z);
    for (std::size_t i = 1; i < line.size(); ++i) {
      const double out = level_distance(line[i].at.x, line[i].at.y);
      const std::size_t to = layer_of(line[i].at.z);
      // Between the layers of its ends, the reach of a line is interpolated.
      const auto [low, high] = std::minmax(from, to);
      const double per_layer =
          from == to ? 0.0 : (out - before) / (static_cast<double>(to) - static_cast<double>(from));
      for (std::size_t k = low; k <= high; ++k) {
        const double there =
            before + per_layer * (static_cast<double>(k) - static_cast<double>(from));
        reach[k] = std::max(reach[k], there);
      }
      reach[to] = std::max(reach[to], out);
      before = out;
      from = to;
    }
  }
  const double most = *std::max_element(reach.begin(), reach.end());
  // Gaps between branches, and parts close to the stem, must not be enlarged.
  constexpr double kLeast = 0.25;
  std::array<double, kLayers> smooth{};
  for (std::size_t k = 0; k < kLayers; ++k) {
    const std::size_t low = k > 0 ? k - 1 : 0;
    const std::size_t high = std::min(k + 1, kLayers - 1);
    smooth[k] = std::max({reach[low], reach[k], reach[high], kLeast * most, 1e-9 * high_});
  }
  for (int pass = 0; pass < 3; ++pass) {
    const std::array<double, kLayers> rough = smooth;
    for (std::size_t k = 0; k < kLayers; ++k) {
      const std::size_t low = k > 0 ? k - 1 : 0;
      const std::size_t high = std::min(k + 1, kLayers - 1);
      smooth[k] = 0.25 * rough[low] + 0.5 * rough[k] + 0.25 * rough[high];
    }
  }
  return smooth;
}

double CrownMap::share_of(double grown_z) const {
  const double share = std::min((grown_z - low_) / (high_ - low_), 1.0);
  // Parts below the lowest height stay below, by the slope at that height.
  return share < 0.0 ? share / skew_ : share / (share + skew_ * (1.0 - share));
}

double CrownMap::reach_at(double share) const {
  const double at = std::clamp(share * kLayers - 0.5, 0.0, kLayers - 1.0);
  const std::size_t below = std::min(static_cast<std::size_t>(at), kLayers - 2);
  return reach_[below] + (at - static_cast<double>(below)) * (reach_[below + 1] - reach_[below]);
}

double CrownMap::widest() const { return *std::max_element(reach_.begin(), reach_.end()); }

double CrownMap::width_at(double share) const {
  const double at = std::clamp(share, 0.0, 1.0) * kWidths;
  const std::size_t below = std::min(static_cast<std::size_t>(at), kWidths - 1);
  return widths_[below] + (at - static_cast<double>(below)) * (widths_[below + 1] - widths_[below]);
}

double CrownMap::grown_height(double z_m) const {
  const double share =
      std::clamp((z_m - crown_.hcb_m()) / (crown_.h_m() - crown_.hcb_m()), 0.0, 1.0);
  return low_ + (high_ - low_) * skew_ * share / (1.0 - share + skew_ * share);
}

CrownPlace CrownMap::place_of(Point grown) const {
  const double share = share_of(grown.z);
  const double distance = level_distance(grown.x, grown.y);
  CrownPlace place;
  place.z_m = crown_.hcb_m() + share * (crown_.h_m() - crown_.hcb_m());
  place.out = drawn_in(distance / reach_at(share), outliers_) * width_at(share);
  if (distance > 1e-12 * high_) {
    place.x = grown.x / distance;
    place.y = grown.y / distance;
  }
  return place;
}

Point CrownMap::at(const CrownPlace& place) const {
  const double distance = place.out * crown_.radius_m(place.x, place.y);
  return {distance * place.x, distance * place.y, place.z_m};
}

Point CrownMap::inside(const CrownPlace& place) const {
  const double low = crown_.down_m(place.out, 1.0);
  const double depth = crown_.up_m(place.out, 1.0) - low;
  constexpr double kNoDepth = 1e-9;
  const double share = depth > kNoDepth ? between_curves((place.z_m - low) / depth) : 0.5;
  const double distance = place.out * crown_.radius_m(place.x, place.y);
  return {distance * place.x, distance * place.y, low + share * depth};
}

}  // namespace silvafit::tree
