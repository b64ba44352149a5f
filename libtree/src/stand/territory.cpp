// SPDX-License-Identifier: MIT
#include "silvafit/tree/territory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

bool touches_any(const std::vector<Lane>& lanes, Point center, double radius_m) {
  return std::any_of(
      lanes.begin(), lanes.end(), [&](const Lane& lane) { return lane.touches(center, radius_m); });
}

}  // namespace

double relative_distance(const Crown& crown, Point point, double outward_m) {
  if (point.z < crown.hcb_m() || point.z > crown.h_m()) return kInfinity;
  const double distance = std::max(std::hypot(point.x, point.y) + outward_m, 0.0);
  if (distance == 0.0) return 0.0;
  const double width = crown.relative_width(point.z) * crown.radius_m(point.x, point.y);
  return width > 0.0 ? distance / width : kInfinity;
}

Lane::Lane(std::vector<SkeletonPoint> line)
    : line_(std::move(line)),
      least_{kInfinity, kInfinity, kInfinity},
      most_{-kInfinity, -kInfinity, -kInfinity} {
  for (const SkeletonPoint& point : line_) {
    const double r = point.radius_m;
    least_ = {std::min(least_.x, point.at.x - r),
              std::min(least_.y, point.at.y - r),
              std::min(least_.z, point.at.z - r)};
    most_ = {std::max(most_.x, point.at.x + r),
             std::max(most_.y, point.at.y + r),
             std::max(most_.z, point.at.z + r)};
  }
}

double Lane::clearance_m(Point center, double radius_m) const {
  double least = kInfinity;
  for (std::size_t i = 1; i < line_.size(); ++i) {
    const SkeletonPoint& a = line_[i - 1];
    const SkeletonPoint& b = line_[i];
    const Point along = b.at - a.at;
    const double squared = dot(along, along);
    const double share =
        squared > 0.0 ? std::clamp(dot(center - a.at, along) / squared, 0.0, 1.0) : 0.0;
    const auto [at, radius] = between(a, b, share);
    least = std::min(least, length(center - at) - radius);
  }
  return least - radius_m;
}

double Lane::at_least_m(Point center, double radius_m) const {
  const double x = center.x - std::clamp(center.x, least_.x, most_.x);
  const double y = center.y - std::clamp(center.y, least_.y, most_.y);
  const double z = center.z - std::clamp(center.z, least_.z, most_.z);
  const double distance = std::sqrt(x * x + y * y + z * z);
  // Inside the box only the lane's own radius is known.
  return distance > 0.0 ? distance - radius_m : -std::numeric_limits<double>::infinity();
}

bool Lane::touches(Point center, double radius_m) const {
  if (center.x + radius_m < least_.x || center.x - radius_m > most_.x ||
      center.y + radius_m < least_.y || center.y - radius_m > most_.y ||
      center.z + radius_m < least_.z || center.z - radius_m > most_.z) {
    return false;
  }
  return clearance_m(center, radius_m) <= 0.0;
}

Territory::Territory(std::shared_ptr<const Crown> own,
                     std::shared_ptr<const std::vector<Lane>> own_lanes,
                     std::vector<Neighbor> neighbors)
    : own_(std::move(own)), own_lanes_(std::move(own_lanes)), neighbors_(std::move(neighbors)) {}

bool Territory::holds_against(const Neighbor& neighbor, Point center, double radius_m) const {
  const Point at = center - neighbor.stem;
  if (touches_any(*neighbor.lanes, at, radius_m)) return false;
  const Crown& crown = *neighbor.crown;
  if (at.z < crown.hcb_m() || at.z > crown.h_m()) return true;
  const double reach = crown.radii().widest_m() + radius_m + kClearance;
  if (at.x * at.x + at.y * at.y > reach * reach) return true;
  const double theirs = relative_distance(crown, at, -radius_m - kClearance);
  if (theirs >= 1.0) return true;
  // Branches that determine the surface may touch it, except for rounding.
  constexpr double kRounding = 1e-9;
  const double ours = relative_distance(*own_, center, radius_m + kClearance);
  return ours <= std::exp(neighbor.log_share + kRounding) * theirs;
}

bool Territory::holds(Point center, double radius_m) const {
  if (neighbors_.empty() || touches_any(*own_lanes_, center, 0.0)) return true;
  return std::all_of(neighbors_.begin(), neighbors_.end(), [&](const Neighbor& neighbor) {
    return holds_against(neighbor, center, radius_m);
  });
}

double Territory::held_share(std::span<const SkeletonPoint> line) const {
  if (neighbors_.empty()) return 1.0;
  double held = 0.0;
  bool all = true;
  walk(line, [&](double share, const SkeletonPoint& point) {
    all = holds(point.at, point.radius_m);
    if (all) held = share;
    return all;
  });
  return all ? 1.0 : held;
}

}  // namespace silvafit::tree
