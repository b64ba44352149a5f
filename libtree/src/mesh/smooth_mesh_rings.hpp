// SPDX-License-Identifier: MIT
// Rings along the curves of limbs.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/curve_sampler.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

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
