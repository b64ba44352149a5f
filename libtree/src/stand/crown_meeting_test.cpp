// SPDX-License-Identifier: MIT
#include "silvafit/tree/crown_meeting.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "test_support/stand_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// A crown with one radius all round; both indices 2.
Crown round_crown(double h, double hc, double hcb, double radius, double index = 2.0) {
  return Crown(
      {.dbh_cm = 20, .h_m = h, .hcb_m = hcb, .hc_m = hc, .radii = {radius, radius, radius, radius}},
      {index, index});
}

}  // namespace

TEST_CASE("trees 1 and 11 of the paper do not overlap") {
  // Table 1 of the paper; of tree 11 only the position and one radius are known.
  const Position tree_1{4246.742, 70203.39, 0};
  const Position tree_11{4250.612, 70204.545, 0};
  const double distance = level_distance_m(tree_1, tree_11);
  CHECK(distance == Approx(4.04).margin(0.005));  // printed with two digits
  const Crown first = round_crown(20.2, 8.8, 5.8, 2.1);
  const Crown second = round_crown(20, 9, 6, 1.9);
  CHECK_FALSE(overlap({first, 2.1}, {second, 1.9}, distance));
  CHECK_FALSE(crown_meeting({first, 2.1}, {second, 1.9}, distance));
}

TEST_CASE("trees 10 and 13 of the paper overlap and meet at its heights") {
  const Morphology tree_10 = test::paper_tree_10();
  const Morphology tree_13 = test::paper_tree_13();
  const double distance = level_distance_m(tree_10.position, tree_13.position);
  CHECK(distance == Approx(2.69).margin(0.005));
  const Crown first = round_crown(19.1, 14, 8, 1.7);
  const Crown second = round_crown(21, 14.5, 5.2, 1.7);
  CHECK(overlap({first, 1.7}, {second, 1.7}, distance));
  // The paper takes both stems on one level here, and rounds its coefficients: 16.33 and 11.49.
  const auto meeting = crown_meeting({first, 1.7}, {second, 1.7}, distance);
  REQUIRE(meeting);
  CHECK(meeting->kind == CrownMeeting::Kind::kUpUpAndDownDown);
  CHECK(meeting->up_m == Approx(16.35).margin(0.005));
  CHECK(meeting->down_m == Approx(11.47).margin(0.005));
  CHECK(meeting->up_m == Approx(16.33).margin(0.03));
  CHECK(meeting->down_m == Approx(11.49).margin(0.03));
}

TEST_CASE("a meeting lies on both crown curves") {
  Random random(30);
  int met = 0;
  for (int i = 0; i < 400; ++i) {
    const double index = random.uniform(1.0, 2.0);
    const auto draw = [&] {
      const double h = random.uniform(6, 25);
      const double hcb = h * random.uniform(0.1, 0.5);
      return round_crown(
          h, hcb + (h - hcb) * random.uniform(0.1, 0.8), hcb, random.uniform(0.5, 3), index);
    };
    const Crown a = draw();
    const Crown b = draw();
    const double ground = random.uniform(-2, 2);
    const double distance = random.uniform(0.5, 5);
    const FacingCrown first{a, a.radii().east_m, 0.0};
    const FacingCrown second{b, b.radii().east_m, ground};
    const auto meeting = crown_meeting(first, second, distance);
    if (!meeting) continue;
    ++met;
    CHECK(meeting->up_m >= meeting->down_m);
    // The outlines as the paper prints them.
    const auto up = [&](const Crown& c, double x) {
      return c.h_m() - (c.h_m() - c.hc_m()) * std::pow(x / c.radii().east_m, index);
    };
    const auto down = [&](const Crown& c, double x) {
      return c.hcb_m() + (c.hc_m() - c.hcb_m()) * std::pow(x / c.radii().east_m, index);
    };
    const double x = meeting->up_distance_m;
    // After 60 bisections only rounding errors are left.
    CHECK(up(a, x) == Approx(meeting->up_m).margin(1e-9));
    CHECK(ground + up(b, distance - x) == Approx(meeting->up_m).margin(1e-9));
    const double y = meeting->down_distance_m;
    const double lower_a = down(a, y);
    const double lower_b = ground + down(b, distance - y);
    if (meeting->kind == CrownMeeting::Kind::kUpUpAndDownDown) {
      CHECK(lower_a == Approx(meeting->down_m).margin(1e-9));
      CHECK(lower_b == Approx(meeting->down_m).margin(1e-9));
    } else {
      const double upper_a = up(a, y);
      const double upper_b = ground + up(b, distance - y);
      const bool first_low = std::abs(upper_a - lower_b) < 1e-9;
      const bool second_low = std::abs(upper_b - lower_a) < 1e-9;
      CHECK((first_low || second_low));
    }
  }
  CHECK(met > 50);
}

TEST_CASE("a low crown meets a high one with its upper curve twice") {
  const Crown low = round_crown(12, 5, 2, 2);
  const Crown high = round_crown(20, 11, 8, 2);
  const auto meeting = crown_meeting({low, 2.0}, {high, 2.0}, 2.2);
  REQUIRE(meeting);
  CHECK(meeting->kind == CrownMeeting::Kind::kUpUpAndUpDown);
  // By hand: 12 - 1.75 x^2 = 8 + 0.75 (2.2 - x)^2, that is 2.5 x^2 - 3.3 x - 0.37 = 0.
  const double x = (3.3 + std::sqrt(3.3 * 3.3 + 4 * 2.5 * 0.37)) / 5.0;
  CHECK(meeting->down_distance_m == Approx(x).epsilon(1e-9));
  CHECK(meeting->down_m == Approx(12 - 1.75 * x * x).epsilon(1e-9));
}

TEST_CASE("crowns that pass above one another do not meet") {
  const Crown low = round_crown(6, 4, 2, 2);
  const Crown high = round_crown(20, 12, 8, 2);
  CHECK(overlap({low, 2.0}, {high, 2.0}, 3.0));
  CHECK_FALSE(crown_meeting({low, 2.0}, {high, 2.0}, 3.0));
}

TEST_CASE("competition of trees 10 and 13 is the paper's") {
  const Crown first = round_crown(19.1, 14, 8, 1.7);
  const Crown second = round_crown(21, 14.5, 5.2, 1.7);
  const Competition ten = competition({first, 1.7, -4.304}, {second, 1.7, -3.589});
  CHECK(ten.horizontal == Approx(1.0).epsilon(1e-12));
  // By hand: 19.1 / (21 + 0.715).
  CHECK(ten.vertical == Approx(19.1 / 21.715).epsilon(1e-12));
  CHECK(ten.total == Approx(0.940).margin(0.0005));
  CHECK(first_is_weaker(ten) == true);
  const Competition thirteen = competition({second, 1.7, -3.589}, {first, 1.7, -4.304});
  CHECK(first_is_weaker(thirteen) == false);
  CHECK_FALSE(first_is_weaker(competition({first, 1.7, 3}, {first, 1.7, 3})));
  // The origin of the frame does not matter.
  CHECK(competition({first, 1.7, 100 - 4.304}, {second, 1.7, 100 - 3.589}).total ==
        Approx(ten.total).epsilon(1e-12));
}
