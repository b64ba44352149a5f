// SPDX-License-Identifier: MIT
// Plausible values of nonlinear coefficients, derived from the scales of the data.
#pragma once

#include <cstddef>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Points that cover sign and logarithm of q coefficients (Halton's sequence): three quarters of
/// each coefficient within a decade and a half of a scale of the data (a rate times a column is of
/// order one), the others anywhere in sixteen decades.
class CandidatePoints {
 public:
  CandidatePoints(const NonlinearModel& model, Index coefficients);

  /// Magnitudes of order one, of the columns of the formula, and of their inverses.
  const std::vector<double>& scales() const { return scales_; }
  /// (q) the point with an index from 1.
  VectorXd operator()(std::size_t number) const;

 private:
  double magnitude(double u) const;

  Index coefficients_ = 0;
  std::vector<double> scales_;
};

}  // namespace silvafit::fit
