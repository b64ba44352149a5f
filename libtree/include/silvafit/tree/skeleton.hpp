// SPDX-License-Identifier: MIT
// The axes of a tree: stem, branches, twigs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"
#include "silvafit/tree/preset.hpp"

namespace silvafit::tree {

/// In place of the number of an axis or a point: there is none.
inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct SkeletonPoint {
  Point at{};
  double radius_m = 0.0;
};

/// The thinnest radius of wood: a float at the height of the tallest tree still resolves it.
inline constexpr double kThinnestWoodM = 0.0003;

/// A point of the straight line between two others, at a proportion of it.
inline SkeletonPoint between(const SkeletonPoint& from, const SkeletonPoint& to, double part) {
  return {from.at + part * (to.at - from.at), from.radius_m + part * (to.radius_m - from.radius_m)};
}

/// A line of points from base to tip. The stem has order 0; an axis that grows from one of order i
/// has order i + 1.
struct Axis {
  std::uint32_t order = 0;
  std::uint32_t parent = 0;  ///< index of the parent axis; that of the stem is itself
  std::uint32_t first = 0;   ///< its first point
  std::uint32_t count = 0;   ///< number of points, at least 2
};

/// A leaf, or an image of several, if the builder itself places foliage.
struct LeafSite {
  Point at{};      ///< its base
  Point along{};   ///< from base to tip, of length 1
  Point facing{};  ///< away from its upper side, of length 1 and at a right angle to `along`
  double length_m = 0.0;
  std::uint32_t axis = 0;   ///< index of its axis
  std::uint32_t grade = 0;  ///< index of the preset's leaf type
};

/// The axes of one tree in its own frame. The stem comes first, parents before children.
struct Skeleton {
  std::vector<SkeletonPoint> points{};
  std::vector<Axis> axes{};
  std::vector<LeafSite> leaves{};  ///< none if foliage follows from the axes alone
  std::vector<Note> notes{};

  /// Starts an axis after the others.
  /// \returns its index
  std::uint32_t add_axis(std::uint32_t order, std::uint32_t parent) {
    axes.push_back({order, parent, static_cast<std::uint32_t>(points.size()), 0});
    return static_cast<std::uint32_t>(axes.size() - 1);
  }
  /// Adds a point to the last axis.
  void add_point(Point at, double radius_m) {
    points.push_back({at, radius_m});
    ++axes.back().count;
  }
  std::uint32_t add_axis(std::uint32_t order,
                         std::uint32_t parent,
                         std::span<const SkeletonPoint> line) {
    const std::uint32_t axis = add_axis(order, parent);
    points.insert(points.end(), line.begin(), line.end());
    axes.back().count = static_cast<std::uint32_t>(line.size());
    return axis;
  }

  std::span<const SkeletonPoint> points_of(const Axis& axis) const {
    return {points.data() + axis.first, axis.count};
  }
};

/// Random numbers of one tree: the same for the same seed, plot and tree, independent of other
/// trees.
Random random_of_tree(std::uint64_t seed, std::string_view plot, std::string_view tree);

/// Heights of the stem's sections: every 0.2 m from the ground, 1.3 m, and the tip.
std::vector<double> section_heights_m(double h_m);

}  // namespace silvafit::tree
