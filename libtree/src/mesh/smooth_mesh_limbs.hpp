// SPDX-License-Identifier: MIT
// The axes of a skeleton as curves, common to all levels of detail of a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "mesh/hermite.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// One curve: an axis, the axis that continues it, if any, and so on.
struct Limb {
  std::uint32_t axis = 0;         ///< its start
  std::uint32_t first = 0;        ///< its first knot
  std::uint32_t count = 0;        ///< number of knots, at least 2
  std::uint32_t bearer = kNone;   ///< parent limb; the stem has none
  std::uint32_t bearer_knot = 0;  ///< the knot of the parent before its base
  double bearer_share = 0.0;      ///< and the relative length up to the next
  double bearer_along_m = 0.0;    ///< length of the parent's curve up to there
  /// Length over which the tube widens from a base that fits into the parent; 0 if the base is thin
  /// enough [m].
  double collar_m = 0.0;
};

/// Curves through all axes that are thick enough to be wood.
///
/// Branches start on the smooth curves of their parents, which deviate from the straight lines of
/// the skeleton, and turn away from them gradually. An axis that starts at its parent's end with
/// the same thickness continues that curve.
class Limbs {
 public:
  explicit Limbs(const Skeleton& skeleton);

  std::span<const Limb> all() const { return limbs_; }
  std::span<const HermiteKnot> knots_of(const Limb& limb) const {
    return {knots_.data() + limb.first, limb.count};
  }

  /// Its curve between each knot and the next.
  std::span<const HermitePiece> pieces_of(const Limb& limb) const {
    return {pieces_.data() + limb.first, limb.count - 1};
  }

  /// The number of a limb's knots that belong to axes up to this order; those needed for a
  /// measurement are always included. 0 if nothing of the limb is drawn.
  std::size_t drawn_knots(const Limb& limb, int wood_order) const;

  /// Displacement of the curve from a point beside the axis on the skeleton's lines.
  Point moved(std::uint32_t axis, Point place) const;

 private:
  /// Beside the piece that starts at a knot, at a relative length.
  struct Place {
    std::uint32_t knot = 0;
    double share = 0.0;
  };

  void find_continuations();
  void mark_measured();
  void mark(std::uint32_t axis);
  void add_limb(std::uint32_t axis);
  void add_knots(std::uint32_t axis, std::uint32_t order);
  void add_knot(const SkeletonPoint& point, std::uint32_t order);
  void place_on_bearer(Limb& limb, std::uint32_t axis);
  bool is_wood(std::uint32_t axis) const;
  Place nearest(std::uint32_t axis, Point place) const;
  /// The point at this distance from both ends of the limb, if it is long enough.
  Place away_from_ends(const Limb& limb, Place place, double distance_m) const;
  HermiteKnot on_curve(const Limb& limb, Place place) const;

  const Skeleton& skeleton_;
  std::vector<Limb> limbs_;
  std::vector<HermiteKnot> knots_;
  std::vector<HermitePiece> pieces_;     ///< that start at the knots; the last of a limb is empty
  std::vector<std::uint32_t> orders_;    ///< of the piece that ends at a knot; 0: always drawn
  std::vector<std::uint32_t> limb_of_;   ///< by axis; kNone if it is not wood
  std::vector<std::uint32_t> first_of_;  ///< by axis: index of its first knot in its limb
  std::vector<std::uint32_t> last_of_;   ///< and of its last one
  std::vector<std::uint32_t> continuation_of_;  ///< by axis: the one that continues it
  std::vector<bool> is_needed_;                 ///< by axis: a measurement of the tree ends on it
};

}  // namespace silvafit::tree
