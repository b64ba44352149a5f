// SPDX-License-Identifier: MIT
// The tree to which a point belongs if crowns overlap.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Relative position of a point in a crown: its distance from the stem's axis divided by the
/// crown's width at this height and in this azimuth. 0 on the axis, 1 on the crown's surface,
/// infinite above and below the crown.
/// \param outward_m  measure a point this much farther out; inward if negative
double relative_distance(const Crown& crown, Point point, double outward_m = 0.0);

/// The space around a stem, or around a branch at a measured crown radius: all points within the
/// radius of a line.
class Lane {
 public:
  /// \param line  at least two points; their radii are the lane's
  explicit Lane(std::vector<SkeletonPoint> line);

  const std::vector<SkeletonPoint>& line() const { return line_; }
  /// Distance of a ball's surface from the lane's [m]; below 0 if they overlap.
  double clearance_m(Point center, double radius_m = 0.0) const;
  /// A lower bound of the same, from the lane's bounding box.
  double at_least_m(Point center, double radius_m = 0.0) const;
  /// Whether a ball touches the lane.
  bool touches(Point center, double radius_m = 0.0) const;

 private:
  std::vector<SkeletonPoint> line_;
  Point least_{};
  Point most_{};
};

/// The space of one tree among its neighbors, in the tree's own frame.
///
/// A point in the crowns of both tree i and neighbor j belongs to i if s_i <= l_ij s_j, where s is
/// relative_distance() and l_ij = 1 / l_ji gives the position of the *meeting surface* s_i = l_ij
/// s_j between the two stems. With l = 1 it contains the curve in which both crown surfaces meet.
/// Lanes have priority: a point in a lane belongs to the lane's tree.
class Territory {
 public:
  struct Neighbor {
    std::shared_ptr<const Crown> crown{};
    Point stem{};                                      ///< base of its stem in this tree's frame
    double log_share = 0.0;                            ///< ln l_ij
    std::shared_ptr<const std::vector<Lane>> lanes{};  ///< in the neighbor's frame
  };

  /// A tree without neighbors owns all space.
  Territory() = default;
  Territory(std::shared_ptr<const Crown> own,
            std::shared_ptr<const std::vector<Lane>> own_lanes,
            std::vector<Neighbor> neighbors);

  bool is_alone() const { return neighbors_.empty(); }
  const std::vector<Neighbor>& neighbors() const { return neighbors_; }

  /// Whether a ball is in the tree's space, or in no crown of a neighbor, with a distance of at
  /// least kClearance.
  bool holds(Point center, double radius_m = 0.0) const;

  /// The relative length of a line, from its start, that is in the tree's space; 1 for all of it.
  double held_share(std::span<const SkeletonPoint> line) const;

 private:
  bool holds_against(const Neighbor& neighbor, Point center, double radius_m) const;

  std::shared_ptr<const Crown> own_{};
  std::shared_ptr<const std::vector<Lane>> own_lanes_{};
  std::vector<Neighbor> neighbors_{};
};

/// Minimum distance of wood and foliage from the meeting surface [m], so that nothing crosses it
/// between two tested points.
inline constexpr double kClearance = 0.005;

}  // namespace silvafit::tree
