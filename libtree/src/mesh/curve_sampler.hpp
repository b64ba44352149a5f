// SPDX-License-Identifier: MIT
// Sections at equal steps of a limb's curve.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/smooth_mesh_limbs.hpp"

namespace silvafit::tree {

/// A section of a tube, orthogonal to `tangent`. `sideways` and `upward` are orthogonal to it and
/// to each other; all three have length 1.
struct Ring {
  Point at{};
  double radius_m = 0.0;
  Point tangent{};
  Point sideways{};
  Point upward{};
  double along_m = 0.0;   ///< length of the curve up to here
  bool is_fixed = false;  ///< drawn for any tolerance

  /// A direction of the plane (x, y) in the plane of the ring.
  Point across(Point flat) const { return flat.x * sideways + flat.y * upward; }
  /// Rotates the ring orthogonal to a direction, keeping its own sideways as far as possible.
  void turn(Point along, Point aside);
};

/// Distance of a ring from the straight tube between two others.
struct RingOffset {
  Point middle{};
  Point sideways{};  ///< of the end of the sideways radius, in addition to the center's
  Point upward{};
};

/// At the ring's relative position between `a` and `b`, or at the nearer one if outside.
RingOffset offset_between(const Ring& a, const Ring& b, const Ring& ring);

/// Equal steps of one limb's curve with frames that do not twist about it. The last one is its tip.
///
/// On the stem breast height is a step too; the steps below and above are equal among
/// themselves. Sections are horizontal below it and nearly so a little above, so that none of them
/// crosses breast height.
class CurveSampler {
 public:
  /// \param pieces       of the drawn part of the limb's curve
  /// \param tolerance_m  maximum error of straight lines between the steps
  void sample(std::span<const HermitePiece> pieces,
              const Limb& limb,
              double tolerance_m,
              std::vector<Ring>& samples);

  /// The same with steps of a given length, or slightly less.
  void sample_evenly(std::span<const HermitePiece> pieces,
                     const Limb& limb,
                     double step_m,
                     std::vector<Ring>& samples);

 private:
  void begin(std::span<const HermitePiece> pieces, const Limb& limb);
  void add_samples(const Limb& limb, std::vector<Ring>& samples);
  void add_steps(double from_m, double to_m, std::vector<Ring>& samples);
  void insert(double along_m, std::vector<Ring>& samples);
  Ring ring_at(double along_m);

  std::span<const HermitePiece> pieces_{};
  std::vector<double> ends_;      ///< length of the curve up to the end of each piece
  double breast_height_m_ = 0.0;  ///< length up to breast height, on the stem
  double step_m_ = 0.0;           ///< that satisfies the tolerance
  std::size_t piece_ = 0;         ///< the piece of the last step
};

}  // namespace silvafit::tree
