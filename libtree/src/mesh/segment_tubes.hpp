// SPDX-License-Identifier: MIT
// Tubes around the straight axes of the segment builder.
#pragma once

#include <span>
#include <vector>

#include "mesh/part_builder.hpp"
#include "mesh/tube.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Tolerance for a shift of the stem's axis relative to that for its radius.
inline constexpr double kBendTolerance = 5.0;

/// A closed tube around a stem, its sections with the areas of their circles; with roots if it has
/// a texture.
void add_stem(std::span<const SkeletonPoint> stem, const MeshOptions& options, PartBuilder& build);

/// The stem and the branches of a segment skeleton that are drawn.
///
/// Each branch starts in its parent, open or closed as in the options, widens into the stem, and
/// ends in a point. Rings are moved and made thinner if the polygon around them would leave the
/// crown. A branch that is too short for floats is not drawn.
class SegmentTubes {
 public:
  /// \param only  if given, only what this draws, too
  SegmentTubes(const Skeleton& skeleton,
               const Crown& crown,
               const MeshOptions& options,
               const SegmentTubes* only = nullptr);

  void add_to(PartBuilder& stem, PartBuilder& branches) const;

  /// As Mesh::surface_error_m.
  double surface_error_m() const;

 private:
  std::span<const Ring> of(std::size_t axis) const {
    return {rings_.data() + first_[axis], first_[axis + 1] - first_[axis]};
  }
  int sides_of(std::size_t axis) const;
  /// \param drawn  for the points of the bearer
  double left_out_m(std::size_t axis,
                    const MeshOptions& finest,
                    std::vector<SkeletonPoint>& drawn) const;

  const Skeleton& skeleton_;
  const Crown& crown_;
  const MeshOptions& options_;
  std::vector<Ring> rings_{};
  std::vector<std::size_t> first_{0};  ///< of each axis
};

}  // namespace silvafit::tree
