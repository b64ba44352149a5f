// SPDX-License-Identifier: MIT
// The evidence of a fit: did it converge, and why we think so.
#pragma once

#include <string>
#include <vector>

namespace silvafit::fit {

/// What an optimization knows about the point where it stopped.
struct Convergence {
  bool converged = false;
  /// One sentence for people: what was reached, or what went wrong and what to try.
  std::string verdict{};
  /// Newton decrement g' H^-1 g: the squared distance to the optimum in standard errors.
  double gradient = 0.0;
  int iterations = 0;
  /// Number of coefficients that the data determine; less than their number means confounding.
  int rank = 0;
  /// What lies on the boundary of its range, e.g. "sd(b) = 0" or "cor(a, b) = 1".
  std::vector<std::string> boundary{};
};

}  // namespace silvafit::fit
