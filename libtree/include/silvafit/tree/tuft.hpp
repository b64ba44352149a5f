// SPDX-License-Identifier: MIT
// A tuft of leaves at the end of a shoot.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Leaves in a golden-angle spiral about the end of a shoot that grows along z and ends at the
/// origin. A leaf has length 1; it is folded along its middle.
///
/// There are two versions. In one, every leaf has its own corners. In the other, corners of
/// neighboring leaves that are close to each other are merged: the leaves are less regular, and the
/// tuft has a third of the points.
struct Tuft {
  /// Indices of a leaf's points: base, right, tip, left.
  using Leaf = std::array<std::uint8_t, 4>;

  std::vector<Point> points{};  ///< 4 per leaf: base, right, tip, left
  std::vector<Point> joint_points{};
  std::vector<Leaf> joint_leaves{};

  /// \param leaves  2 to 60
  /// \param aspect  width by length of a leaf, > 0
  static Tuft of(int leaves, double aspect);
};

}  // namespace silvafit::tree
