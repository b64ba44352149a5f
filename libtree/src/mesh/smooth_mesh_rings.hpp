// SPDX-License-Identifier: MIT
// Sections at equal steps along the curves of limbs, and the rings that are drawn of them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/tube.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

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

/// The rings of all limbs of a tree.
class WoodRings {
 public:
  /// \param step_m  all steps of this length are drawn, for any tolerance; 0 for none
  WoodRings(const Limbs& limbs,
            const Crown& crown,
            const MeshOptions& options,
            double step_m = 0.0);

  /// None if a limb is not drawn. The last one is the tip, where the tube ends in a point.
  std::span<const Ring> of(std::size_t limb) const {
    return {rings_.data() + first_[limb], first_[limb + 1] - first_[limb]};
  }
  int sides_of(const Limb& limb) const;

  /// Omits limbs that are thinner than this at their base, except those that define a measurement.
  void omit_thinner(double diameter_m);
  /// Draws such limbs as a straight line from their base to their tip.
  void straighten_thinner(double diameter_m);

 private:
  void add(const Limb& limb);
  void keep_rings(const std::vector<bool>& is_kept);
  bool is_omitted(const Limb& limb, double thinnest_m) const;
  void take_steps(const Limb& limb, std::size_t drawn_knots);
  void place_base(const Limb& limb, Ring& base) const;
  double collar_radius_m(const Limb& limb) const;
  void fit_into_crown(Ring& ring, std::span<const Point> corners) const;
  void fit_base_into_crown(const Limb& limb, std::span<const Point> corners, Ring& base) const;
  void keep_advancing(const Limb& limb, std::span<const Point> corners);
  std::span<const Point> corners_of(const Limb& limb) const;

  const Limbs& limbs_;
  const Crown& crown_;
  const MeshOptions& options_;
  double step_m_;
  CurveSampler sampler_;
  std::vector<Ring> rings_;
  std::vector<std::size_t> first_;
  std::vector<Ring> samples_;  ///< of the current limb
  std::vector<Ring> kept_;     ///< the drawn ones
  std::vector<Point> branch_corners_;
  std::vector<Point> twig_corners_;
};

}  // namespace silvafit::tree
