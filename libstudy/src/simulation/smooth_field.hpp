// SPDX-License-Identifier: MIT
// Smooth random surfaces.
#pragma once

#include <vector>

#include "silvafit/base/random.hpp"

namespace silvafit::study {

/// A smooth random function of the plane, close to a standard Gaussian field: a sum of cosine waves
/// with random directions and phases.
/// Source: random Fourier features of a Gaussian covariance, exp(-d^2 / (2 length^2)); Rahimi and
/// Recht 2007, Advances in Neural Information Processing Systems 20.
class SmoothField {
 public:
  SmoothField(double length_m, Random& random);
  double operator()(double x, double y) const;

 private:
  struct Wave {
    double kx = 0.0;
    double ky = 0.0;
    double phase = 0.0;
  };
  std::vector<Wave> waves_;
};

}  // namespace silvafit::study
