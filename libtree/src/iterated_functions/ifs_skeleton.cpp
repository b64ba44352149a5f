// SPDX-License-Identifier: MIT
// Recursive copies of a trunk.
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "iterated_functions/ifs.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// A placed copy of the trunk.
struct Copy {
  AffineMap place{};
  double scale = 1.0;
  double radius = 0.0;
  int depth = 0;
  std::uint32_t axis = 0;
  std::uint32_t first = 0;     ///< point of its axis at its base
  std::uint32_t children = 0;  ///< entry of the first map in children_
};

class Grower {
 public:
  Grower(const IfsPreset& preset, Random& random) : preset_(preset), random_(random) {}

  Skeleton grow(bool has_leaves) {
    copies_.push_back({.radius = preset_.trunk.radius});
    grow_axis(0, 0, 0);
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      const Start start = starts_[i];
      grow_axis(start.copy, start.order, start.parent);
    }
    // Last, so that the branches have the same random numbers without leaves.
    const std::size_t leaves = has_leaves ? preset_.leaves.count : 0;
    for (std::size_t i = 0; i < leaves; ++i) add_leaf();
    return std::move(skeleton_);
  }

 private:
  /// A copy from which an axis starts.
  struct Start {
    std::uint32_t copy = 0;
    std::uint32_t order = 0;
    std::uint32_t parent = 0;
  };

  /// The copy's trunk and its continuation.
  void grow_axis(std::uint32_t copy, std::uint32_t order, std::uint32_t parent) {
    const std::uint32_t axis = skeleton_.add_axis(order, parent);
    skeleton_.add_point(copies_[copy].place.b, copies_[copy].radius);
    while (copy != kNone) {
      copies_[copy].axis = axis;
      copies_[copy].first = static_cast<std::uint32_t>(skeleton_.points.size() - 1);
      const std::uint32_t next = bear(copy, order, axis);
      add_trunk(copy, next);
      copy = next;
    }
  }

  /// Makes the copies on a copy.
  /// \return the one that continues it, if there is one
  std::uint32_t bear(std::uint32_t copy, std::uint32_t order, std::uint32_t axis) {
    const std::size_t maps = preset_.copies.size();
    copies_[copy].children = static_cast<std::uint32_t>(children_.size());
    children_.resize(children_.size() + maps, kNone);
    std::uint32_t next = kNone;
    if (copies_[copy].depth >= preset_.limits.depth) return next;
    for (std::size_t m = 0; m < maps; ++m) {
      const IfsCopy& map = preset_.copies[m];
      if (order < map.from_order || order > map.to_order) continue;
      const Copy child = varied(copies_[copy], map);
      if (child.scale < preset_.limits.least_scale) continue;
      if (copies_.size() >= preset_.limits.most_copies) {
        throw GeometryError("the iterated function system makes more than " +
                            std::to_string(preset_.limits.most_copies) +
                            " copies; reduce its depth or increase its least_scale");
      }
      const auto number = static_cast<std::uint32_t>(copies_.size());
      children_[copies_[copy].children + m] = number;
      copies_.push_back(child);
      if (map.continues) {
        next = number;
      } else {
        starts_.push_back({number, order + 1, axis});
      }
    }
    return next;
  }

  Copy varied(const Copy& bearer, const IfsCopy& map) {
    const IfsVariation& variation = preset_.variation;
    AffineMap local = map.map;
    Copy copy{.scale = bearer.scale * map.scale,
              .radius = bearer.radius * map.thickness,
              .depth = bearer.depth + 1};
    const auto draw = [this](double most) {
      return most > 0.0 ? random_.uniform(-most, most) : 0.0;
    };
    const double share = draw(variation.scale);
    const double azimuth = kRadian * draw(variation.azimuth_deg);
    const double tilt = kRadian * draw(variation.angle_deg);
    const double towards =
        variation.angle_deg > 0.0 ? random_.uniform(0.0, 2.0 * std::numbers::pi) : 0.0;
    if (share != 0.0) {
      local = scaled(local, 1.0 + share);
      copy.scale *= 1.0 + share;
    }
    const Point base = local.b;
    local.b = {};
    if (azimuth != 0.0) local = turn_about({0.0, 0.0, 1.0}, azimuth).after(local);
    if (tilt != 0.0) {
      local = turn_about({std::cos(towards), std::sin(towards), 0.0}, tilt).after(local);
    }
    local.b = base;
    copy.place = bearer.place.after(local);
    return copy;
  }

  /// The points of a copy's trunk without the first.
  void add_trunk(std::uint32_t number, std::uint32_t next) {
    const Copy& copy = copies_[number];
    const IfsTrunk& trunk = preset_.trunk;
    const double tip = next != kNone ? copies_[next].radius : trunk.tip_radius * copy.radius;
    const auto stray = [&] {
      return trunk.crookedness > 0.0 ? random_.uniform(-trunk.crookedness, trunk.crookedness) : 0.0;
    };
    for (int i = 1; i <= trunk.segments; ++i) {
      const double share = static_cast<double>(i) / trunk.segments;
      const double radius = copy.radius + share * (tip - copy.radius);
      Point at{0.0, 0.0, share};
      if (i < trunk.segments) {
        at.x = stray();
        at.y = stray();
      }
      skeleton_.add_point(copy.place(at), radius);
    }
  }

  /// On the last of the copies that the maps' probabilities select.
  void add_leaf() {
    std::uint32_t copy = 0;
    while (true) {
      const std::uint32_t child = drawn_child(copy);
      if (child == kNone) break;
      copy = child;
    }
    const Copy& bearer = copies_[copy];
    const auto points = static_cast<std::uint32_t>(preset_.trunk.segments);
    const double share = random_.uniform() * points;
    const auto segment = std::min(static_cast<std::uint32_t>(share), points - 1);
    const Point a = skeleton_.points[bearer.first + segment].at;
    const Point b = skeleton_.points[bearer.first + segment + 1].at;
    const Point along = direction(b - a);
    const double azimuth = random_.uniform(0.0, 2.0 * std::numbers::pi);
    const Point aside = direction(cross(along, {0.6, -0.48, 0.64}), {1.0, 0.0, 0.0});
    const Point across = std::cos(azimuth) * aside + std::sin(azimuth) * cross(along, aside);
    const double angle = kRadian * preset_.leaves.angle_deg;
    LeafSite leaf{.at = a + (share - segment) * (b - a), .axis = bearer.axis};
    leaf.along = direction(std::cos(angle) * along + std::sin(angle) * across);
    // The upper side points up as far as the leaf's direction allows.
    const Point up{0.0, 0.0, 1.0};
    leaf.facing = direction(up - dot(up, leaf.along) * leaf.along, across);
    leaf.length_m = preset_.leaves.length;
    skeleton_.leaves.push_back(leaf);
  }

  std::uint32_t drawn_child(std::uint32_t copy) {
    const std::size_t maps = preset_.copies.size();
    const std::uint32_t first = copies_[copy].children;
    double sum = 0.0;
    for (std::size_t m = 0; m < maps; ++m) {
      if (children_[first + m] != kNone) sum += preset_.copies[m].probability;
    }
    if (sum == 0.0) return kNone;
    double left = random_.uniform() * sum;
    std::uint32_t last = kNone;
    for (std::size_t m = 0; m < maps; ++m) {
      if (children_[first + m] == kNone) continue;
      last = children_[first + m];
      left -= preset_.copies[m].probability;
      if (left < 0.0) break;
    }
    return last;
  }

  const IfsPreset& preset_;
  Random& random_;
  Skeleton skeleton_{};
  std::vector<Copy> copies_{};
  std::vector<std::uint32_t> children_{};  ///< by copy and map; none if a copy was omitted
  std::vector<Start> starts_{};
};

}  // namespace

Skeleton grow_ifs(const IfsPreset& preset, Random& random, bool has_leaves) {
  return Grower(preset, random).grow(has_leaves);
}

}  // namespace silvafit::tree
