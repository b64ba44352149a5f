// SPDX-License-Identifier: MIT
// Branch segment models: branches shared by the trees of a stand.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// A first-order branch with its twigs and foliage. It starts at the origin and its tip lies in the
/// east, in the mesh's frame: at (length sin angle, length cos angle, 0) with y up.
struct BranchModel {
  double angle_deg = 0.0;  ///< from the vertical
  double length_m = 0.0;   ///< of the straight line from base to tip
  Mesh mesh{};             ///< branches and foliage
};

/// Placement of a model in a tree: scaled, then rotated in the vertical plane through east, then
/// about the vertical, then moved to its base. Base and tip are then those of the tree's branch.
struct BranchPlacement {
  std::size_t model = 0;     ///< index in the library
  std::uint32_t axis = 0;    ///< of the skeleton
  double scale = 1.0;        ///< length of the branch divided by that of the model
  double tilt_rad = 0.0;     ///< added to the model's angle from the vertical
  double azimuth_rad = 0.0;  ///< clockwise from north
  Point base{};              ///< in the tree's frame
};

/// A point of a model, in the tree's frame.
Point placed(const BranchPlacement& placement, Point of_model);

/// 7 angles (30 to 90 degrees by 10) and 8 lengths (0.4 to 3.2 m by 0.4) of one species, as in the
/// paper on segment models. A tree drawn with them needs its stem and one placement per branch. Its
/// branches start and end at the right points; between, they have the shape of the nearest model,
/// turned by at most 5 degrees, and scaled if the branch is longer than the longest model.
class BranchLibrary {
 public:
  static constexpr int kAngles = 7;
  static constexpr int kLengths = 8;

  /// \param seed  of the random numbers; the same seed gives the same models
  static BranchLibrary build(const Preset& preset,
                             std::uint64_t seed = 1,
                             const MeshOptions& options = {});

  /// Angles first, lengths within an angle.
  const std::vector<BranchModel>& models() const { return models_; }

  /// Index of the model nearest in angle and in length.
  std::size_t nearest(double angle_rad, double length_m) const;

  /// A placement for each first-order branch of a skeleton, in its order.
  std::vector<BranchPlacement> place(const Skeleton& skeleton) const;

 private:
  std::vector<BranchModel> models_;
};

}  // namespace silvafit::tree
