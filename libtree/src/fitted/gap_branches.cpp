// SPDX-License-Identifier: MIT
#include "fitted/gap_branches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "morphology/crown_gaps.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

/// Points in space, of which only the near ones are compared with another one.
class NearPoints {
 public:
  explicit NearPoints(double distance)
      : distance_(distance),
        side_(static_cast<int>(std::ceil(2.0 / distance)) + 2),
        cells_(index(side_ - 1, side_ - 1, side_ - 1) + 1) {}

  void add(Point at) {
    const auto [x, y, z] = cell_of(at);
    cells_[index(x, y, z)].push_back(at);
  }

  bool has_near(Point at) const {
    const auto [x, y, z] = cell_of(at);
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, side_ - 1); ++i) {
      for (int j = std::max(y - 1, 0); j <= std::min(y + 1, side_ - 1); ++j) {
        for (int k = std::max(z - 1, 0); k <= std::min(z + 1, side_ - 1); ++k) {
          for (const Point& other : cells_[index(i, j, k)]) {
            const Point apart = other - at;
            if (dot(apart, apart) < distance_ * distance_) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  std::array<int, 3> cell_of(Point at) const {
    const auto along = [this](double value) {
      return std::clamp(static_cast<int>((value + 1.0) / distance_), 0, side_ - 1);
    };
    return {along(at.x), along(at.y), along(at.z)};
  }

  std::size_t index(int x, int y, int z) const {
    const auto side = static_cast<std::size_t>(side_);
    return (static_cast<std::size_t>(x) * side + static_cast<std::size_t>(y)) * side +
           static_cast<std::size_t>(z);
  }

  double distance_;
  int side_;
  std::vector<std::vector<Point>> cells_;
};

/// Where a branch starts.
struct Fork {
  std::uint32_t axis = kNone;
  SkeletonPoint base{};
  Point along{};  ///< direction of the bearer there
};

class GapFiller {
 public:
  GapFiller(Skeleton& skeleton, const Crown& crown, double largest_gap)
      : skeleton_(skeleton), crown_(crown), gaps_(crown), occupied_(largest_gap) {}

  void run() {
    const std::size_t grown = skeleton_.axes.size();
    for (std::uint32_t i = 0; i < grown; ++i) {
      add_forks(i);
      if (i > 0) occupy(skeleton_.points_of(skeleton_.axes[i]));
    }
    measure_leaves();
    // Steps of the golden ratio: neighbors are not filled one after the other.
    constexpr std::size_t kNumber = std::size_t{kLayers} * kAzimuths * kDepths.size();
    constexpr std::size_t kStep = 433;
    static_assert(std::gcd(kNumber, kStep) == 1);
    for (std::size_t i = 0; i < kNumber; ++i) fill(place_of(i * kStep % kNumber));
  }

 private:
  static constexpr int kLayers = 14;
  static constexpr int kAzimuths = 25;
  static constexpr std::array<double, 2> kDepths{0.88, 0.48};
  static constexpr double kLowest = 0.1;  ///< the crown's end below is a point

  /// Leaves are on the outer part of a branch.
  void occupy(std::span<const SkeletonPoint> line) {
    constexpr double kBare = 0.35;
    constexpr int kPlaces = 3;
    for (int k = 0; k < kPlaces; ++k) {
      const double share = kBare + (1.0 - kBare) * k / (kPlaces - 1);
      occupied_.add(unit(point_at(line, share).at));
    }
  }

  /// With heights from -1 at the crown base to 1 at the top.
  Point unit(Point at) const {
    return gaps_.scaled({at.x, at.y, at.z - 0.5 * (crown_.hcb_m() + crown_.h_m())});
  }

  Point place_of(std::size_t number) const {
    const std::size_t column = number / kDepths.size();
    const std::size_t row = column / kAzimuths;
    const auto layer = static_cast<double>(row);
    const auto sector = static_cast<double>(column % kAzimuths);
    const double share = kLowest + (1.0 - kLowest) * (layer + 0.5) / kLayers;
    const double z = crown_.hcb_m() + share * (crown_.h_m() - crown_.hcb_m());
    const double azimuth = kTwoPi * (sector / kAzimuths + std::numbers::phi * layer);
    const Point out{std::cos(azimuth), std::sin(azimuth), 0.0};
    const double width_m = crown_.radius_m(out.x, out.y) * crown_.relative_width(z);
    Point place = kDepths[number % kDepths.size()] * width_m * out;
    place.z = z;
    return place;
  }

  void fill(Point place) {
    if (occupied_.has_near(unit(place))) return;
    const Fork fork = fork_for(place);
    if (fork.axis == kNone) return;
    const std::uint32_t axis = skeleton_.add_axis(skeleton_.axes[fork.axis].order + 1, fork.axis);
    const Point chord = place - fork.base.at;
    const double long_m = length(chord);
    // As branches of that length are elsewhere, and thinner than their bearer.
    constexpr double kRadiusPerMeter = 0.008;
    constexpr double kOfBearer = 0.6;
    const double radius_m = std::min(kRadiusPerMeter * long_m, kOfBearer * fork.base.radius_m);
    // It leaves its bearer at a smaller angle than it has later.
    constexpr double kBend = 0.22;
    constexpr int kSegments = 3;
    const Point bow = kBend * long_m * direction(direction(chord) + fork.along, direction(chord));
    for (int k = 0; k <= kSegments; ++k) {
      const double share = static_cast<double>(k) / kSegments;
      const Point at =
          fork.base.at + share * chord + 4.0 * share * (1.0 - share) * (1.0 - share) * bow;
      skeleton_.add_point(k == 0 ? at : crown_.confine(at), (1.0 - share) * radius_m);
    }
    occupy(skeleton_.points_of(skeleton_.axes.back()));
    add_forks(axis);
    add_leaves(axis);
  }

  /// Places on an axis from which branches may start.
  void add_forks(std::uint32_t axis) {
    const auto line = skeleton_.points_of(skeleton_.axes[axis]);
    constexpr double kThinnestBearer = 0.006;
    if (line.front().radius_m < kThinnestBearer) return;
    for (std::size_t k = 1; k < line.size(); ++k) {
      const Point step = line[k].at - line[k - 1].at;
      for (const double share : {0.2, 0.7}) {
        const SkeletonPoint from = between(line[k - 1], line[k], share);
        if (crown_.contains(from.at)) forks_.push_back({axis, from, direction(step)});
      }
    }
  }

  /// The nearest place on a bearer from which the branch need not turn back.
  Fork fork_for(Point place) const {
    // Branches of the lower crown may turn back a little; none doubles its bearer.
    constexpr double kBack = -0.2;
    constexpr double kBeside = 0.9;
    constexpr double kAside = 1.6;
    constexpr double kLongest = 0.9;
    double best = kLongest * crown_.radii().width_m();
    Fork nearest;
    for (const Fork& fork : forks_) {
      const Point chord = place - fork.base.at;
      const double squared = dot(chord, chord);
      constexpr double kLeast = kAside - kBeside;
      if (kLeast * kLeast * squared >= best * best) continue;
      const double long_m = std::sqrt(squared);
      const double along_m = dot(chord, fork.along);
      if (along_m < kBack * long_m || along_m > kBeside * long_m) continue;
      const double cost = kAside * long_m - along_m;
      if (cost >= best || !crown_.contains(fork.base.at + 0.5 * chord)) continue;
      best = cost;
      nearest = fork;
    }
    return nearest;
  }

  void measure_leaves() {
    for (const LeafSite& leaf : skeleton_.leaves) leaf_m_ += leaf.length_m;
    if (!skeleton_.leaves.empty()) leaf_m_ /= static_cast<double>(skeleton_.leaves.size());
  }

  /// Leaves of the mean length at both sides of a branch, without gaps.
  void add_leaves(std::uint32_t axis) {
    if (!(leaf_m_ > 0.0)) return;
    const auto line = skeleton_.points_of(skeleton_.axes[axis]);
    constexpr double kBare = 0.2;
    constexpr int kMost = 60;
    const double leafy_m = (1.0 - kBare) * line_length_m(line);
    const int number = std::clamp(static_cast<int>(2.0 * leafy_m / leaf_m_), 1, kMost);
    const Point along = direction(line.back().at - line.front().at);
    const Point aside = direction(cross(along, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    for (int k = 0; k < number; ++k) {
      const double share = 1.0 - (1.0 - kBare) * k / number;
      const Point at = crown_.confine(point_at(line, share).at);
      const Point out = direction((k % 2 == 0 ? 1.0 : -1.0) * aside + along);
      const Point upper = direction(cross(cross(out, {0.0, 0.0, 1.0}), out), aside);
      const double inside_m = crown_.length_inside_m(at, out, leaf_m_);
      constexpr double kLeast = 0.3;
      if (inside_m < kLeast * leaf_m_) continue;
      skeleton_.leaves.push_back({at, out, upper, inside_m, axis, skeleton_.leaves.front().grade});
    }
  }

  Skeleton& skeleton_;
  const Crown& crown_;
  CrownGaps gaps_;
  std::vector<Fork> forks_{};
  NearPoints occupied_;  ///< by branches, in the coordinates of unit()
  double leaf_m_ = 0.0;  ///< mean length of the leaves
};

}  // namespace

void fill_gaps(Skeleton& skeleton, const Crown& crown, double largest_gap) {
  GapFiller(skeleton, crown, largest_gap).run();
}

}  // namespace silvafit::tree
