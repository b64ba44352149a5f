// SPDX-License-Identifier: MIT
#include "stand/radius_branch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

/// A possible course of a branch to its tip.
struct Course {
  double azimuth_rad = 0.0;  ///< rotation of the tip
  double rise = 0.0;         ///< of the tip, -1 .. 1: from the lower to the upper crown curve
  double angle_rad = 0.0;    ///< from the vertical; 0: unchanged
  double bow_up = 0.0;       ///< at mid-length, relative to the length
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

/// From the smallest change to the largest.
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

/// The obstacles around a branch. The obstacle and the piece at which one course was rejected are
/// tested first for the next one, because courses differ little.
class Way {
 public:
  explicit Way(std::span<const Obstacle> obstacles)
      : obstacles_(obstacles.begin(), obstacles.end()) {}

  /// Distance of the wood from the nearest obstacle's surface [m], or kLaneMargin if it is larger.
  /// \param enough  smaller distances need not be computed exactly
  double clearance_m(std::span<const SkeletonPoint> wood, double enough) {
    take_points(wood);
    double least = kLaneMargin;
    for (std::size_t i = 0; i < obstacles_.size(); ++i) {
      least = std::min(least, from(obstacles_[i], least, enough));
      if (least <= enough) {
        std::swap(obstacles_.front(), obstacles_[i]);
        break;
      }
    }
    return least;
  }

 private:
  /// Neighboring points, and a ball around them.
  struct Piece {
    std::span<const SkeletonPoint> points{};
    Point middle{};
    double reach_m = 0.0;
  };

  static Piece piece_of(std::span<const SkeletonPoint> points) {
    Piece piece{.points = points, .middle = 0.5 * (points.front().at + points.back().at)};
    for (const SkeletonPoint& point : points) {
      piece.reach_m = std::max(piece.reach_m, length(point.at - piece.middle) + point.radius_m);
    }
    return piece;
  }

  /// The line as a whole, and points along it.
  void take_points(std::span<const SkeletonPoint> wood) {
    whole_ = piece_of(wood);
    points_.clear();
    walk(wood, [this](double, const SkeletonPoint& point) {
      points_.push_back(point);
      return true;
    });
    pieces_.assign((points_.size() + kPiece - 1) / kPiece, {});
  }

  /// The piece with this index; most courses are rejected before all pieces are needed.
  const Piece& piece(std::size_t number) {
    Piece& piece = pieces_[number];
    if (piece.points.empty()) {
      const std::size_t from = number * kPiece;
      piece = piece_of(std::span(points_).subspan(from, std::min(kPiece, points_.size() - from)));
    }
    return piece;
  }

  /// Whether a piece cannot be nearer to an obstacle than this.
  static bool is_beyond(const Piece& piece, const Obstacle& obstacle, double least) {
    return obstacle.lane->at_least_m(piece.middle - obstacle.stem, piece.reach_m) >= least;
  }

  static double from(const Piece& piece, const Obstacle& obstacle, double least, double enough) {
    if (is_beyond(piece, obstacle, least)) return least;
    for (const SkeletonPoint& point : piece.points) {
      const Point at = point.at - obstacle.stem;
      if (obstacle.lane->at_least_m(at, point.radius_m) >= least) continue;
      least = std::min(least, obstacle.lane->clearance_m(at, point.radius_m));
      if (least <= enough) break;
    }
    return least;
  }

  /// The distance from one obstacle, or anything from `least` up if it is not below that, or
  /// anything up to `enough`.
  double from(const Obstacle& obstacle, double least, double enough) {
    if (is_beyond(whole_, obstacle, least)) return least;
    const std::size_t first = std::min(met_, pieces_.size() - 1);
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      // The first one, then those before it, then those after it.
      const std::size_t number = k == 0 ? first : (k <= first ? k - 1 : k);
      least = std::min(least, from(piece(number), obstacle, least, enough));
      if (least <= enough) {
        met_ = number;
        break;
      }
    }
    return least;
  }

  static constexpr std::size_t kPiece = 8;  ///< points

  std::vector<Obstacle> obstacles_;
  std::vector<SkeletonPoint> points_{};
  Piece whole_{};
  std::vector<Piece> pieces_{};
  std::size_t met_ = 0;  ///< index of the piece that met an obstacle last
};

}  // namespace

Lane lane_round(std::span<const SkeletonPoint> wood) {
  std::vector<SkeletonPoint> line(wood.begin(), wood.end());
  for (SkeletonPoint& point : line) point.radius_m += kLaneMargin;
  return Lane(std::move(line));
}

double clearance_m(std::span<const SkeletonPoint> wood, std::span<const Obstacle> obstacles) {
  return Way(obstacles).clearance_m(wood, -std::numeric_limits<double>::infinity());
}

std::vector<SkeletonPoint> turned(std::span<const SkeletonPoint> wood,
                                  bool on_stem,
                                  const Crown& crown,
                                  std::span<const Obstacle> obstacles) {
  static const std::vector<Course> kCourses = courses();
  const Turner turner(wood, on_stem, crown);
  Way way(obstacles);
  std::vector<SkeletonPoint> best(wood.begin(), wood.end());
  double widest = way.clearance_m(wood, -std::numeric_limits<double>::infinity());
  for (const Course& course : kCourses) {
    if (widest >= kLaneMargin) break;
    std::vector<SkeletonPoint> line = turner.line(course);
    const double clearance = way.clearance_m(line, widest);
    if (clearance > widest) {
      widest = clearance;
      best = std::move(line);
    }
  }
  return best;
}

}  // namespace silvafit::tree
