// SPDX-License-Identifier: MIT
// Faster convergence of a fixed-point iteration x = T(x).
#pragma once

#include <deque>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Anderson's mixing of the last few iterates: from x and T(x) it proposes the next x. Cycles are
/// damped and slow linear convergence becomes fast; with no memory it is the plain iteration.
/// Source: Walker and Ni 2011, SIAM Journal on Numerical Analysis 49, 1715-1735.
class AndersonMixing {
 public:
  explicit AndersonMixing(std::size_t memory) : memory_(memory) {}

  /// The next point to try, given x and its image.
  VectorXd next(const VectorXd& x, const VectorXd& image);
  void restart();

 private:
  std::size_t memory_;
  std::deque<VectorXd> image_changes_;
  std::deque<VectorXd> residual_changes_;
  VectorXd last_image_;
  VectorXd last_residual_;
};

}  // namespace silvafit::fit
