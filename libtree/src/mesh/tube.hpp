// SPDX-License-Identifier: MIT
// Tubes around axes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/part_builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// How much more than a change of its radius a shift of the stem's axis may be.
inline constexpr double kBendTolerance = 5.0;

/// Those points of the stem without which its radius would be off by more than the tolerance, or
/// its axis by more than kBendTolerance times that; the ends and breast height always.
void needed_sections(std::span<const SkeletonPoint> stem,
                     double tolerance_m,
                     std::vector<SkeletonPoint>& sections);

/// The same for a branch: its ends, and what bows by more than the tolerance between them.
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

/// The rings of a branch's tube and the point in which it ends: the needed points, moved and made
/// thinner where the polygon around them would leave the crown. Only the end is left of a branch
/// that is too short for floats.
void branch_rings(std::span<const SkeletonPoint> branch,
                  double tolerance_m,
                  const TubeFrame& frame,
                  int sides,
                  const Crown& crown,
                  std::vector<SkeletonPoint>& rings);

/// A closed tube around the stem, its sections as large as the circles they stand for.
void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build);

/// Tubes around branches. Each begins in its parent, open or closed as the options say, and ends in
/// a point. Its vertices stay inside the crown.
class BranchTubes {
 public:
  BranchTubes(const Crown& crown, const MeshOptions& options, PartBuilder& build);

  /// Makes room for all branches of a tree at once.
  void reserve(const Skeleton& skeleton);

  /// Nothing is added for a branch too short for a float to tell its ends apart.
  void add(std::span<const SkeletonPoint> branch);

 private:
  void add_ring(const SkeletonPoint& ring,
                const TubeFrame& frame,
                const std::vector<Point>& polygon,
                double v,
                double lean);

  const Crown& crown_;
  const MeshOptions& options_;
  PartBuilder& build_;
  std::vector<Point> branch_polygon_;
  std::vector<Point> twig_polygon_;
  std::vector<SkeletonPoint> points_;
};

}  // namespace silvafit::tree
