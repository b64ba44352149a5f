// SPDX-License-Identifier: MIT
#include "mesh/boughs.hpp"

#include <catch2/catch.hpp>

using namespace silvafit::tree;

namespace {

/// A crown of radius 2 m about (0, 0, 4 m), and branches to its east and west.
struct Ball {
  Crown crown{{.dbh_cm = 10, .h_m = 6, .hcb_m = 2, .hc_m = 4, .radii = {2, 2, 2, 2}}, {2, 2}};
  Skeleton skeleton{};

  Ball() {
    skeleton.add_axis(0, 0);
    skeleton.add_point({0, 0, 0}, 0.05);
    skeleton.add_point({0, 0, 6}, 0.0);
    for (const double x : {2.0, -2.0}) {
      skeleton.add_axis(1, 0);
      skeleton.add_point({0, 0, 4}, 0.02);
      skeleton.add_point({x, 0, 4}, 0.0);
    }
  }
};

}  // namespace

TEST_CASE("a crown with grooves reaches its surface at the ends of its branches only") {
  const Ball ball;
  const Boughs boughs(ball.skeleton, ball.crown, 0.4);
  CHECK(boughs.contain({1.99, 0.0, 4.0}));
  CHECK(boughs.contain({-1.99, 0.0, 4.0}));
  // As far from the eastern as from the western end: six tenths of the radius are left.
  CHECK(boughs.contain({0.0, -0.99 * 0.6 * 2.0, 4.0}));
  CHECK_FALSE(boughs.contain({0.0, -1.01 * 0.6 * 2.0, 4.0}));
}

TEST_CASE("leaves face away from the inside of their bough") {
  const Ball ball;
  const Boughs boughs(ball.skeleton, ball.crown, 0.4);
  // The core of the eastern bough is 0.65 of the way to its end: at 1.3 m.
  const Point out = boughs.outward({1.3, 0.5, 4.0});
  CHECK(out.x == Approx(0.0).margin(1e-12));
  CHECK(out.y == Approx(1.0));
  CHECK(boughs.outward({1.9, 0.0, 4.0}).x == Approx(1.0));
}

TEST_CASE("without grooves a crown is one") {
  const Ball ball;
  const Boughs whole(ball.skeleton, ball.crown, 0.0);
  CHECK(whole.contain({0.0, -1.99, 4.0}));
  CHECK(length(whole.outward({1.0, 0.0, 4.0})) == 0.0);
}
