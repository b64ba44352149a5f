// SPDX-License-Identifier: MIT
// Tubes around axes.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "part_builder.hpp"
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

/// A closed tube around the stem, its sections as large as the circles they stand for.
void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build);

/// Tubes around branches. Each begins in its parent, open or closed as the options say, and ends in
/// a point. Its vertices stay inside the crown.
class BranchTubes {
 public:
  BranchTubes(const Crown& crown, const MeshOptions& options, PartBuilder& build);

  /// Nothing is added for a branch too short for a float to tell its ends apart.
  void add(std::span<const SkeletonPoint> branch, std::uint32_t order);

 private:
  struct Ring {
    Point center{};
    double radius_m = 0.0;
  };
  struct Frame {
    Point tangent{};
    Point sideways{};
    Point upward{};
  };

  Ring fitted(Ring ring, const Frame& frame, const std::vector<Point>& polygon) const;
  void add_ring(const Ring& ring,
                const Frame& frame,
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
