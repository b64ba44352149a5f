// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "silvafit/base/constants.hpp"
#include "silvafit/tree/preset.hpp"

namespace silvafit::tree {
namespace {

/// Corners of one leaf of the spiral; `share` is from 0 at the lowest to 1 at the uppermost.
std::array<Point, 4> spiral_leaf(int number, double share, double aspect) {
  constexpr double kDivergence = 137.507764 * kRadian;
  constexpr double kShoot = 1.1;    // length with leaves
  constexpr double kLowest = 95.0;  // degrees between shoot and leaf
  constexpr double kUppermost = 25.0;
  constexpr double kFold = 0.12;
  const double azimuth = kDivergence * number;
  const double angle = kRadian * (kLowest + share * (kUppermost - kLowest));
  const Point out = {std::cos(azimuth), std::sin(azimuth), 0.0};
  const Point along = std::sin(angle) * out + Point{0.0, 0.0, std::cos(angle)};
  const Point side = {-out.y, out.x, 0.0};
  const Point back = cross(along, side);
  const Point base = {0.0, 0.0, -kShoot * (1.0 - share)};
  const Point middle = base + 0.5 * along + kFold * back;
  return {base, middle + 0.5 * aspect * side, base + along, middle - 0.5 * aspect * side};
}

double doubled_area(Point a, Point b, Point c) { return length(cross(b - a, c - a)); }

/// Merges the points of leaves, the closest first.
class Joiner {
 public:
  explicit Joiner(const std::vector<Point>& points)
      : points_(points), weights_(points.size(), 1.0) {
    for (std::size_t i = 0; i < points.size(); ++i) group_.push_back(i);
    groups_ = points.size();
    for (std::size_t leaf = 0; leaf < points.size(); leaf += 4)
      areas_.push_back(smaller_half(leaf));
  }

  void join_until(std::size_t wanted) {
    while (groups_ > wanted && join_closest()) {
    }
  }

  Tuft taken() const {
    Tuft tuft;
    std::vector<std::size_t> number(points_.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (group_[i] != i) continue;
      number[i] = tuft.points.size();
      tuft.points.push_back(points_[i]);
    }
    for (std::size_t leaf = 0; leaf < points_.size(); leaf += 4) {
      Tuft::Leaf corners{};
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = static_cast<std::uint8_t>(number[group_[leaf + k]]);
      }
      tuft.leaves.push_back(corners);
    }
    return tuft;
  }

 private:
  Point corner(std::size_t i) const { return points_[group_[i]]; }

  double smaller_half(std::size_t leaf) const {
    return std::min(doubled_area(corner(leaf), corner(leaf + 1), corner(leaf + 2)),
                    doubled_area(corner(leaf), corner(leaf + 2), corner(leaf + 3)));
  }

  bool join_closest() {
    double least = std::numeric_limits<double>::infinity();
    std::size_t first = 0;
    std::size_t second = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (group_[i] != i) continue;
      for (std::size_t j = i + 1; j < points_.size(); ++j) {
        if (group_[j] != j) continue;
        const double distance = length(points_[i] - points_[j]);
        if (distance < least && may_join(i, j)) {
          least = distance;
          first = i;
          second = j;
        }
      }
    }
    if (first == second) return false;
    join(first, second);
    return true;
  }

  void join(std::size_t first, std::size_t second) {
    const double sum = weights_[first] + weights_[second];
    points_[first] =
        (1.0 / sum) * (weights_[first] * points_[first] + weights_[second] * points_[second]);
    weights_[first] = sum;
    std::replace(group_.begin(), group_.end(), second, first);
    --groups_;
  }

  /// Not if a leaf would lose more than two thirds of a half.
  bool may_join(std::size_t first, std::size_t second) const {
    constexpr double kLeast = 0.35;
    for (std::size_t leaf = 0; leaf < points_.size(); leaf += 4) {
      bool has_first = false;
      bool has_second = false;
      for (std::size_t k = 0; k < 4; ++k) {
        has_first = has_first || group_[leaf + k] == first;
        has_second = has_second || group_[leaf + k] == second;
      }
      if (has_first && has_second) return false;
    }
    Joiner trial(*this);
    trial.join(first, second);
    for (std::size_t leaf = 0; leaf < points_.size(); leaf += 4) {
      if (trial.smaller_half(leaf) < kLeast * areas_[leaf / 4]) return false;
    }
    return true;
  }

  std::vector<Point> points_;
  std::vector<double> weights_;
  std::vector<std::size_t> group_;
  std::vector<double> areas_;
  std::size_t groups_ = 0;
};

}  // namespace

Tuft Tuft::of(int leaves, double aspect) {
  std::vector<Point> points;
  for (int i = 0; i < leaves; ++i) {
    const double share = leaves > 1 ? i / (leaves - 1.0) : 1.0;
    const std::array<Point, 4> corners = spiral_leaf(i, share, aspect);
    points.insert(points.end(), corners.begin(), corners.end());
  }
  // Two triangles per leaf: with this number of points, a triangle takes 22 bytes of a file.
  constexpr double kPointsPerLeaf = 1.32;
  Joiner joiner(points);
  joiner.join_until(static_cast<std::size_t>(kPointsPerLeaf * leaves));
  return joiner.taken();
}

}  // namespace silvafit::tree
