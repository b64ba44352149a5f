// SPDX-License-Identifier: MIT
#include "silvafit/tree/crown.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

Crown crown_of_tree_1(CrownIndex index = {}) {
  return Crown(complete(test::paper_tree_1(), 0.5, "unused"), index);
}

/// Height above or below which a crown of that radius ends at a distance, by the printed formula.
double outline(const Crown& crown, bool up, double distance, double radius, double index) {
  const double share = std::pow(distance / radius, index);
  return up ? crown.h_m() - (crown.h_m() - crown.hc_m()) * share
            : crown.hcb_m() + (crown.hc_m() - crown.hcb_m()) * share;
}

}  // namespace

// At 1 m from the axis the curves with index 2 differ from the axis by their coefficients. The
// paper prints two decimals.
TEST_CASE("tree 1 of the paper has the printed crown curves") {
  const Crown crown = crown_of_tree_1();
  const double radii[] = {2.1, 2.5, 1.5, 2.4};
  const double up[] = {2.59, 1.82, 5.07, 1.98};
  const double down[] = {0.68, 0.48, 1.33, 0.52};
  for (int i = 0; i < 4; ++i) {
    CHECK(crown.h_m() - crown.up_m(1.0, radii[i]) == Approx(up[i]).margin(0.00501));
    CHECK(crown.down_m(1.0, radii[i]) - crown.hcb_m() == Approx(down[i]).margin(0.00501));
  }
}

TEST_CASE("the crown radius interpolates the four measured ones smoothly") {
  const Crown crown = crown_of_tree_1();
  CHECK(crown.radius_m(1, 0) == 2.1);
  CHECK(crown.radius_m(-3, 0) == 2.5);
  CHECK(crown.radius_m(0, -0.1) == 1.5);
  CHECK(crown.radius_m(0, 2) == 2.4);
  double before = 2.4;
  for (int degree = 1; degree <= 360; ++degree) {
    const double radius = crown.radius_m(std::sin(degree * kRadian), std::cos(degree * kRadian));
    CHECK(radius >= 1.5 - 1e-12);
    CHECK(radius <= 2.5 + 1e-12);
    // The change a radian is the difference of two radii times sin 2 phi, here 1 m at most.
    CHECK(std::abs(radius - before) <= 1.0 * kRadian);
    before = radius;
  }
}

TEST_CASE("a ray leaves the crown where it meets the curve") {
  for (const CrownIndex index : {CrownIndex{2, 2}, {1, 1}, {1.3, 1.7}, {2.6, 3}}) {
    const Crown crown = crown_of_tree_1(index);
    const double radius = 2.1;
    for (double base = 5.8; base < 20.2; base += 0.31) {
      for (const double angle : {10.0, 30.0, 50.0, 70.0, 88.0, 90.0}) {
        const double x = crown.matching_distance_m(base, angle * kRadian, radius);
        const double z = base + x / std::tan(angle * kRadian);
        CHECK(x >= 0.0);
        CHECK(x <= radius * (1 + 1e-12));
        const bool above = z > crown.hc_m();
        const double curve = outline(crown, above, x, radius, above ? index.up : index.down);
        CHECK(z == Approx(curve).margin(1e-9));
      }
    }
  }
}

TEST_CASE("a level branch at the widest height reaches the measured radius") {
  const Crown crown = crown_of_tree_1();
  CHECK(crown.matching_distance_m(8.8, 90 * kRadian, 2.5) == Approx(2.5).epsilon(1e-14));
}

TEST_CASE("confined points are inside, and points inside do not move") {
  const Crown crown = crown_of_tree_1({1.4, 2});
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const Point point{random.uniform(-4, 4), random.uniform(-4, 4), random.uniform(4, 22)};
    const Point inside = crown.confine(point);
    // Both sides of this compare a width as computed by pow and by a table that never exceeds it.
    CHECK(crown.excess_m(inside) <= 1e-12);
    const Point again = crown.confine(inside);
    CHECK(length(again - inside) <= 1e-12);
    const Point half{0.4 * inside.x, 0.4 * inside.y, inside.z};
    if (inside.z > 6.5 && inside.z < 19.5) {
      CHECK(length(crown.confine(half) - half) == 0.0);
    }
  }
}

TEST_CASE("a crown index outside 1 to 3 is refused") {
  CHECK_THROWS_AS(crown_of_tree_1({0.9, 2}), DomainError);
  CHECK_THROWS_AS(crown_of_tree_1({2, 3.1}), DomainError);
  CHECK_THROWS_AS(crown_of_tree_1({NAN, 2}), DomainError);
}
