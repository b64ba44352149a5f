// SPDX-License-Identifier: MIT
#include "radius_branch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace silvafit::tree {
namespace {

constexpr double kRadian = std::numbers::pi / 180.0;

/// One way to lead a branch to its tip.
struct Course {
  double azimuth_rad = 0.0;  ///< turn of the tip
  double rise = 0.0;         ///< of the tip, -1 .. 1: from the lower to the upper crown curve
  double angle_rad = 0.0;    ///< from the vertical; 0: as it was
  double bow_up = 0.0;       ///< at mid-length, as a share of the length
  double bow_aside = 0.0;
};

class Turner {
 public:
  Turner(std::span<const SkeletonPoint> wood, bool on_stem, const Crown& crown)
      : wood_(wood), on_stem_(on_stem), crown_(crown) {}

  std::vector<SkeletonPoint> line(const Course& course) const {
    const Point tip = tip_of(course);
    const Point base = base_of(course, tip);
    const Point along = tip - base;
    const double reach = length(along);
    const Point aside = direction(cross({0.0, 0.0, 1.0}, along), {1.0, 0.0, 0.0});
    constexpr int kSegments = 4;
    std::vector<SkeletonPoint> points;
    for (int i = 0; i <= kSegments; ++i) {
      const double share = static_cast<double>(i) / kSegments;
      const double bow = 4.0 * share * (1.0 - share) * reach;
      const Point straight = base + share * along;
      const Point bent =
          straight + bow * course.bow_up * Point{0.0, 0.0, 1.0} + bow * course.bow_aside * aside;
      const double radius = (1.0 - share) * wood_.front().radius_m;
      points.push_back({i == 0 || i == kSegments ? straight : crown_.confine(bent), radius});
    }
    return points;
  }

 private:
  /// Within a centimeter of the measured radius, as measured within half a degree of the direction.
  Point tip_of(const Course& course) const {
    const Point tip = wood_.back().at;
    if (course.azimuth_rad == 0.0 && course.rise == 0.0) return tip;
    constexpr double kSpared = 0.008;
    const double radius = std::hypot(tip.x, tip.y);
    const double distance = radius - std::min(kSpared, 0.5 * radius);
    const double s = std::sin(course.azimuth_rad);
    const double c = std::cos(course.azimuth_rad);
    const double x = (c * tip.x - s * tip.y) * distance / radius;
    const double y = (s * tip.x + c * tip.y) * distance / radius;
    const double widest = crown_.radius_m(x, y);
    const double share = std::min(distance, widest);
    constexpr double kInside = 0.9;
    const double low = kInside * (crown_.down_m(share, widest) - tip.z);
    const double high = kInside * (crown_.up_m(share, widest) - tip.z);
    const double rise =
        course.rise > 0.0 ? course.rise * std::max(high, 0.0) : -course.rise * std::min(low, 0.0);
    return crown_.confine({x, y, tip.z + rise});
  }

  Point base_of(const Course& course, Point tip) const {
    const Point base = wood_.front().at;
    if (!on_stem_ || course.angle_rad == 0.0) return base;
    const double rise = std::hypot(tip.x, tip.y) / std::tan(course.angle_rad);
    return {base.x, base.y, std::clamp(tip.z - rise, crown_.hcb_m(), tip.z)};
  }

  std::span<const SkeletonPoint> wood_;
  bool on_stem_;
  const Crown& crown_;
};

/// From the least change to the greatest.
std::vector<Course> courses() {
  std::vector<Course> all;
  for (const double aside : {0.0, 0.06, -0.06, 0.12, -0.12}) {
    for (const double up : {0.0, 0.06, -0.06, 0.12, -0.12, 0.2}) {
      for (const double azimuth : {0.0, 0.2, -0.2, 0.4, -0.4}) {
        for (const double rise : {0.0, 0.5, -0.5, 1.0, -1.0}) {
          for (const double angle : {0.0, 90.0, 80.0, 70.0, 60.0, 50.0, 40.0, 30.0}) {
            all.push_back({azimuth * kRadian, rise, angle * kRadian, up, aside});
          }
        }
      }
    }
  }
  return all;
}

}  // namespace

Lane lane_round(std::span<const SkeletonPoint> wood) {
  std::vector<SkeletonPoint> line(wood.begin(), wood.end());
  for (SkeletonPoint& point : line) point.radius_m += kLaneMargin;
  return Lane(std::move(line));
}

double clearance_m(std::span<const SkeletonPoint> wood, std::span<const Obstacle> obstacles) {
  double least = std::numeric_limits<double>::infinity();
  if (obstacles.empty()) return least;
  walk(wood, [&](double, const SkeletonPoint& point) {
    for (const Obstacle& obstacle : obstacles) {
      least = std::min(least, obstacle.lane->clearance_m(point.at - obstacle.stem, point.radius_m));
    }
    return true;
  });
  return least;
}

std::vector<SkeletonPoint> turned(std::span<const SkeletonPoint> wood,
                                  bool on_stem,
                                  const Crown& crown,
                                  std::span<const Obstacle> obstacles) {
  static const std::vector<Course> kCourses = courses();
  const Turner turner(wood, on_stem, crown);
  std::vector<SkeletonPoint> best(wood.begin(), wood.end());
  double widest = clearance_m(wood, obstacles);
  for (const Course& course : kCourses) {
    if (widest >= kLaneMargin) break;
    std::vector<SkeletonPoint> line = turner.line(course);
    const double clearance = clearance_m(line, obstacles);
    if (clearance > widest) {
      widest = clearance;
      best = std::move(line);
    }
  }
  return best;
}

}  // namespace silvafit::tree
