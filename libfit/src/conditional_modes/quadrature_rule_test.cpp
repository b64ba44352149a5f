// SPDX-License-Identifier: MIT
#include "conditional_modes/quadrature_rule.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace silvafit::fit;
using Eigen::Index;

namespace {

/// The rule's mean of exp(t x).
double mean_of_exponential(const QuadratureRule& rule, double t) {
  return (rule.weights.array() * (t * rule.nodes.row(0).transpose().array()).exp()).sum();
}

}  // namespace

TEST_CASE("Gauss-Hermite rules of few points are those of the tables") {
  const QuadratureRule three = gauss_hermite(3, 1);
  CHECK(three.nodes(0, 0) == Approx(-std::sqrt(3.0)).epsilon(1e-15));
  CHECK(std::abs(three.nodes(0, 1)) < 1e-15);
  CHECK(three.weights[0] == Approx(1.0 / 6.0).epsilon(1e-15));
  CHECK(three.weights[1] == Approx(2.0 / 3.0).epsilon(1e-15));
  const QuadratureRule one = gauss_hermite(1, 1);
  CHECK(one.nodes(0, 0) == 0.0);
  CHECK(one.weights[0] == 1.0);
}

TEST_CASE("weights far out are right to their own size") {
  // The mean of exp(t x) is exp(t^2 / 2); its largest part lies at x = t, where the density is
  // exp(-t^2 / 2). Rounding of nodes is all that is left: t times 4e-16 of their size.
  const int points = GENERATE(45, 63, 91, 100);
  const QuadratureRule rule = gauss_hermite(points, 1);
  CHECK(rule.weights.sum() == Approx(1.0).epsilon(1e-14));
  for (const double t : {1.0, 3.0, 5.0, 6.0}) {
    INFO(points << " points, t = " << t);
    CHECK(mean_of_exponential(rule, t) == Approx(std::exp(0.5 * t * t)).epsilon(1e-12));
  }
  // An even moment as high as the rule is exact for, by logarithms: (2 k - 1)!!.
  const int k = points - 1;
  const double moment =
      (rule.weights.array() * rule.nodes.row(0).transpose().array().abs().pow(2.0 * k)).sum();
  const double exact = std::lgamma(2.0 * k + 1.0) - std::lgamma(k + 1.0) - k * std::log(2.0);
  // lgamma and log leave some 1e-15 of a number of several hundred.
  if (std::isfinite(moment)) CHECK(std::log(moment) == Approx(exact).margin(1e-11));
}
