// SPDX-License-Identifier: MIT
// Tubes around axes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/part_builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Tolerance for a shift of the stem's axis relative to that for its radius.
inline constexpr double kBendTolerance = 5.0;

/// The points of the stem that are needed for errors of at most the tolerance for its radius, and
/// kBendTolerance times that for its axis; always the ends and breast height.
void needed_sections(std::span<const SkeletonPoint> stem,
                     double tolerance_m,
                     std::vector<SkeletonPoint>& sections);

/// The same for a branch: its ends, and points where it bends by more than the tolerance.
void needed_points(std::span<const SkeletonPoint> branch,
                   double tolerance_m,
                   std::vector<SkeletonPoint>& needed);

/// Directions along, across and above a branch, the same for all of its rings.
struct TubeFrame {
  Point tangent{};
  Point sideways{};
  Point upward{};

  /// A direction of the plane (x, y) in the plane of the rings.
  Point across(Point flat) const { return flat.x * sideways + flat.y * upward; }
};

TubeFrame frame_of(std::span<const SkeletonPoint> branch);

/// The rings of a branch's tube and the point at its end: the needed points, moved and made
/// thinner if the polygon around them would leave the crown. Only the end is left of a branch
/// that is too short for floats. A branch widens into a bearer of this radius; 0 for none.
void branch_rings(std::span<const SkeletonPoint> branch,
                  double tolerance_m,
                  const TubeFrame& frame,
                  int sides,
                  double bearer_radius_m,
                  const Crown& crown,
                  std::vector<SkeletonPoint>& rings);

/// Radius of the stem where a first-order branch starts; 0 for other axes, which need no collar.
double bearer_radius_m(const Skeleton& skeleton, const Axis& axis);

/// A closed tube around the stem, its sections with the areas of their circles.
void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build);

/// Tubes around branches. Each starts in its parent, open or closed as in the options, and ends in
/// a point. Its vertices are inside the crown.
class BranchTubes {
 public:
  BranchTubes(const Crown& crown, const MeshOptions& options, PartBuilder& build);

  /// Reserves space for all branches of a tree.
  void reserve(const Skeleton& skeleton);

  /// Nothing is added for a branch that is too short for floats.
  void add(std::span<const SkeletonPoint> branch, double bearer_radius_m);

 private:
  void add_ring(const SkeletonPoint& ring,
                const TubeFrame& frame,
                const std::vector<Point>& polygon,
                const BarkScale& scale,
                double along_m,
                double lean);

  const Crown& crown_;
  const MeshOptions& options_;
  PartBuilder& build_;
  std::vector<Point> branch_polygon_;
  std::vector<Point> twig_polygon_;
  std::vector<SkeletonPoint> points_;
};

}  // namespace silvafit::tree
