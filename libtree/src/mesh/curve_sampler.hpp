// SPDX-License-Identifier: MIT
// Sections at equal steps of a limb's curve.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/tube.hpp"

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

}  // namespace silvafit::tree
