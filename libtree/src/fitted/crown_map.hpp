// SPDX-License-Identifier: MIT
// The space round a freely grown tree, mapped onto a measured crown.
#pragma once

#include <array>

#include "fitted/standing_skeleton.hpp"
#include "silvafit/tree/crown.hpp"

namespace silvafit::tree {

/// A place in a crown of any size.
struct CrownPlace {
  double out = 0.0;  ///< distance from the axis as a share of the crown's radius there, 0 .. 1
  double x = 1.0;    ///< level direction, of length 1
  double y = 0.0;
  double z_m = 0.0;  ///< height, before it is bent between the crown's curves
};

/// A smooth map from a standing skeleton's space into a crown.
///
/// Heights are stretched so that the first branch begins near the crown base, the widest part comes
/// near the height of the crown's, and the top is the tree's. At each height distances from the
/// axis are scaled so that what reaches farthest comes to the crown's curve; lone outliers are
/// drawn in more. Near both ends, where a crown has no width, branches keep some length and are
/// bent up or down along the curve instead.
class CrownMap {
 public:
  CrownMap(const StandingSkeleton& grown, const Crown& crown);

  CrownPlace place_of(Point grown) const;
  /// As the place says; near the crown's curves perhaps outside.
  Point at(const CrownPlace& place) const;
  /// The same, but bent between the curves: always inside the crown, up to rounding.
  Point inside(const CrownPlace& place) const;

  /// How far the grown tree reaches from the axis where it is widest.
  double widest() const;
  /// The grown height that comes to a height in the crown.
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
  std::array<double, kWidths + 1> widths_{};  ///< of the crown that branches keep, by height
  double outliers_ = 1.0;  ///< how many times its reach something lies out, at most
};

}  // namespace silvafit::tree
