// SPDX-License-Identifier: MIT
// Whose space a point is where crowns overlap.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// How far out in a crown a point lies: its distance from the stem's axis as a share of the crown's
/// width at this height and in this azimuth. 0 on the axis, 1 on the crown's surface, infinite
/// above and below the crown.
/// \param outward_m  measure a point that lies by so much farther out; inward if negative
double relative_distance(const Crown& crown, Point point, double outward_m = 0.0);

/// The space round a stem, or round a branch that reaches a measured crown radius: all points
/// within the radius of a line.
class Lane {
 public:
  /// \param line  at least two points; their radii are the lane's
  explicit Lane(std::vector<SkeletonPoint> line);

  const std::vector<SkeletonPoint>& line() const { return line_; }
  /// Distance of a ball's surface from the lane's [m]; below 0 where they overlap.
  double clearance_m(Point center, double radius_m = 0.0) const;
  /// A lower bound of the same, from the box round the lane.
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
/// relative_distance() and l_ij = 1 / l_ji says where between the two stems the *meeting surface*
/// s_i = l_ij s_j stands. With l = 1 it passes through the curve in which both crown surfaces meet.
/// Lanes go before: who has a lane there holds the point.
class Territory {
 public:
  struct Neighbor {
    std::shared_ptr<const Crown> crown{};
    Point stem{};                                      ///< base of its stem in this tree's frame
    double log_share = 0.0;                            ///< ln l_ij
    std::shared_ptr<const std::vector<Lane>> lanes{};  ///< in the neighbor's frame
  };

  /// A tree without neighbors holds all space.
  Territory() = default;
  Territory(std::shared_ptr<const Crown> own,
            std::shared_ptr<const std::vector<Lane>> own_lanes,
            std::vector<Neighbor> neighbors);

  bool is_alone() const { return neighbors_.empty(); }
  const std::vector<Neighbor>& neighbors() const { return neighbors_; }

  /// Whether a ball lies in the tree's space, or in no crown of a neighbor, with kClearance to
  /// spare.
  bool holds(Point center, double radius_m = 0.0) const;

  /// The share of a line, from its start, up to which the tree holds it; 1 for all of it.
  double held_share(std::span<const SkeletonPoint> line) const;

 private:
  bool holds_against(const Neighbor& neighbor, Point center, double radius_m) const;

  std::shared_ptr<const Crown> own_{};
  std::shared_ptr<const std::vector<Lane>> own_lanes_{};
  std::vector<Neighbor> neighbors_{};
};

/// What grows keeps this distance [m] from the meeting surface, so that between two points that
/// were looked at nothing passes it.
inline constexpr double kClearance = 0.005;

}  // namespace silvafit::tree
