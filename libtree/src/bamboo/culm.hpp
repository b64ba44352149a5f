// SPDX-License-Identifier: MIT
// The culm of a bamboo: its nodes and its line.
#pragma once

#include <cstdint>
#include <vector>

#include "bamboo/bamboo.hpp"
#include "bamboo/bezier.hpp"

namespace silvafit::tree {

struct CulmNode {
  double z_m = 0.0;
  std::uint32_t number = 0;  ///< from the ground
};

/// A culm upright up to breast height and the crown base and bent above. Its tip nods.
class Culm {
 public:
  Culm(const TreeShape& shape, const Crown& crown, const CulmStyle& style, Random& random);

  /// The culm's center at a height.
  Point at(double z_m) const;
  /// Nodes from the ground up; unless the crown starts near the ground or the tip, one is at the
  /// crown base.
  const std::vector<CulmNode>& nodes() const { return nodes_; }
  const std::vector<Note>& notes() const { return notes_; }

  /// From the ground to the tip, with a ridge at each node; breast height is a point outside all
  /// ridges.
  std::vector<SkeletonPoint> points(const Taper& taper) const;

 private:
  void place_nodes(int internodes, Random& random);
  void bend(const TreeShape& shape, const Crown& crown, double bend_deg);
  Point bow(double z_m) const;

  const CulmStyle& style_;
  double h_m_;
  double hcb_m_;
  double dbh_cm_;
  std::vector<CulmNode> nodes_{};
  double lean_azimuth_deg_ = 0.0;
  double bent_from_m_ = 0.0;  ///< the height of the tip if the culm is straight
  CubicBezier curve_{};       ///< above that
  double bow_m_ = 0.0;        ///< the largest distance from that curve, below the nodding tip
  std::vector<Note> notes_{};
};

}  // namespace silvafit::tree
