// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "bamboo/culm.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;

TEST_CASE("the length of a parabola agrees with its closed form") {
  // y = x^2 over [0, 1] as a cubic: length sqrt(5) / 2 + asinh(2) / 4.
  const CubicBezier parabola{{Point{0, 0, 0}, {1.0 / 3, 0, 0}, {2.0 / 3, 1.0 / 3, 0}, {1, 1, 0}}};
  CHECK(parabola.length_m() == Approx(std::sqrt(5.0) / 2 + std::asinh(2.0) / 4).epsilon(1e-13));
  // x = t: the length up to t is (2t sqrt(1 + 4t^2) + asinh(2t)) / 4.
  for (const double t : {0.1, 0.35, 0.8}) {
    CHECK(parabola.length_m(0.0, t) ==
          Approx((2 * t * std::sqrt(1 + 4 * t * t) + std::asinh(2 * t)) / 4).epsilon(1e-13));
  }
  // There and back on a line: the speed has a zero inside.
  const CubicBezier back{{Point{0, 0, 0}, {2, 0, 0}, {-1, 0, 0}, {1, 0, 0}}};
  // x(t) = 6t - 15t^2 + 10t^3 turns at t = (5 -+ sqrt(5)) / 10.
  const double turn = (5.0 - std::sqrt(5.0)) / 10.0;
  const double top = turn * (6.0 + turn * (-15.0 + 10.0 * turn));
  // At a kink the interval is halved down to 2^-24 of the whole.
  CHECK(back.length_m() == Approx(4.0 * top - 1.0).epsilon(1e-7));
}

TEST_CASE("a bent curve has the requested length, angle and side") {
  const Point along = direction({0.2, -0.3, 0.9});
  const Point side = direction(cross(along, {1.0, 0.0, 0.0}));
  for (const double bend : {0.0, 0.3, 5.0, 40.0, 90.0, 150.0, 179.0}) {
    for (const double sense : {-2.0, 0.0, 1.0}) {
      INFO("bend " << bend << " V " << sense);
      const CubicBezier curve = bent_curve({1, 2, 3}, along, side, 3.7, bend, sense);
      CHECK(length(curve.at(0.0) - Point{1, 2, 3}) == 0.0);
      CHECK(curve.length_m() == Approx(3.7).epsilon(1e-12));
      const Point from = direction(curve.derivative(0.0));
      const Point to = direction(curve.derivative(1.0));
      CHECK(length(from - along) < 1e-12);
      // atan2 is accurate at small angles, where acos loses half of the digits.
      const double angle =
          std::atan2(length(cross(from, to)), dot(from, to)) * 180 / std::numbers::pi;
      CHECK(angle == Approx(sense == 0.0 ? 0.0 : bend).margin(1e-8));
      if (bend > 0.0) {
        const double leaning = dot(to, side);
        CHECK((sense == 0.0 ? std::abs(leaning) < 1e-12 : leaning * sense > 0.0));
      }
      CHECK(std::abs(dot(curve.at(0.5) - Point{1, 2, 3}, cross(along, side))) < 1e-12);
    }
  }
  // Near an arc of a circle: the cubic of a quarter deviates by at most 2.7e-4 of the radius.
  const CubicBezier quarter = bent_curve({}, {1, 0, 0}, {0, 0, 1}, std::numbers::pi / 2, 90.0, 1.0);
  for (double t = 0.0; t <= 1.0; t += 0.05) {
    CHECK(length(quarter.at(t) - Point{0, 0, 1}) == Approx(1.0).margin(2.8e-4));
  }
  CHECK_THROWS_AS(bent_curve({}, along, side, -1.0, 0.0, 1.0), UsageError);
  CHECK_THROWS_AS(bent_curve({}, along, side, 1.0, 180.0, 1.0), UsageError);
  CHECK_THROWS_AS(bent_curve({}, along, side, 1.0, std::nan(""), 1.0), UsageError);
}
