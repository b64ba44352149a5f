// SPDX-License-Identifier: MIT
// The space around a freely grown tree, mapped to a measured crown.
#pragma once

#include <array>

#include "fitted/standing_skeleton.hpp"
#include "silvafit/tree/crown.hpp"

namespace silvafit::tree {

/// A position in a crown of any size.
struct CrownPlace {
  double out = 0.0;  ///< distance from the axis relative to the crown's radius there, 0 .. 1
  double x = 1.0;    ///< horizontal direction, of length 1
  double y = 0.0;
  double z_m = 0.0;  ///< height, before bending between the crown curves
};

/// A smooth map from a standing skeleton's space into a crown.
///
/// Heights are transformed so that the first branch starts near the crown base, the widest part is
/// near the height of the crown's, and the top is the tree's. At each height distances from the
/// axis are scaled so that the farthest point is moved to the crown curve; outliers are
/// compressed. Near both ends, where a crown has no width, branches keep some length and are
/// bent up or down along the curve instead.
class CrownMap {
 public:
  CrownMap(const StandingSkeleton& grown, const Crown& crown);

  CrownPlace place_of(Point grown) const;
  /// The point of a position; near the crown curves possibly outside.
  Point at(const CrownPlace& place) const;
  /// The same, but bent between the curves: always inside the crown, except for rounding.
  Point inside(const CrownPlace& place) const;

  /// The largest distance of the grown tree from the axis.
  double widest() const;
  /// The grown height that is mapped to a height in the crown.
  double grown_height(double z_m) const;

 private:
  static constexpr std::size_t kLayers = 32;
  static constexpr std::size_t kWidths = 128;

  double share_of(double grown_z) const;
  double reach_at(double share) const;
  double width_at(double share) const;
  std::array<double, kLayers> silhouette(const StandingSkeleton& grown) const;
  void match_widest(const StandingSkeleton& grown);

  const Crown& crown_;
  double low_;
  double high_;
  double skew_ = 1.0;
  std::array<double, kLayers> reach_{};       ///< of the grown tree by height
  std::array<double, kWidths + 1> widths_{};  ///< minimum crown width for branches, by height
  double outliers_ = 1.0;  ///< maximum ratio of a distance to the reach at its height
};

}  // namespace silvafit::tree
