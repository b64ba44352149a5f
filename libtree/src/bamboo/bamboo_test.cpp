// SPDX-License-Identifier: MIT
#include "bamboo/bamboo.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "test_support/bamboo_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

std::span<const SkeletonPoint> culm_of(const test::Bamboo& bamboo) {
  return bamboo.skeleton.points_of(bamboo.skeleton.axes.front());
}

/// Heights of ridges: points thicker than the ones below and above.
std::vector<double> ridges_of(const test::Bamboo& bamboo) {
  const auto culm = culm_of(bamboo);
  std::vector<double> heights;
  for (std::size_t i = 1; i + 1 < culm.size(); ++i) {
    if (culm[i].radius_m > culm[i - 1].radius_m && culm[i].radius_m > culm[i + 1].radius_m) {
      heights.push_back(culm[i].at.z);
    }
  }
  return heights;
}

double tip_reach_m(const test::Bamboo& bamboo, Point direction) {
  double reach = 0.0;
  for (const Axis& axis : bamboo.skeleton.axes) {
    if (axis.order != 1) continue;
    const Point tip = bamboo.skeleton.points_of(axis).back().at;
    const double along = dot(tip, direction);
    const Point aside = Point{tip.x, tip.y, 0.0} - along * direction;
    if (length(aside) < 1e-9) reach = std::max(reach, along);
  }
  return reach;
}

}  // namespace

TEST_CASE("the skeleton of any valid bamboo has its measurements and is inside the crown") {
  Random random(40);
  for (int i = 0; i < 400; ++i) {
    const Morphology morphology = test::random_morphology(random, i);
    INFO("tree " << i << " dbh " << morphology.dbh_cm << " h " << morphology.h_m << " hcb "
                 << morphology.hcb_m);
    const test::Bamboo bamboo = test::grown(morphology);
    const auto culm = culm_of(bamboo);
    CHECK(culm.front().at.z == 0.0);
    CHECK(culm.back().at.z == bamboo.shape.h_m);
    CHECK(culm.back().radius_m == 0.0);
    bool rises = true;
    for (std::size_t k = 1; k < culm.size(); ++k) rises = rises && culm[k].at.z > culm[k - 1].at.z;
    CHECK(rises);
    const auto breast = std::find_if(
        culm.begin(), culm.end(), [](const SkeletonPoint& point) { return point.at.z == 1.3; });
    REQUIRE(breast != culm.end());
    CHECK(200.0 * breast->radius_m == Approx(morphology.dbh_cm).epsilon(1e-12));
    CHECK(std::hypot(breast->at.x, breast->at.y) == 0.0);

    double lowest = 1e9;
    double outside = 0.0;
    bool sound = true;
    for (const Axis& axis : bamboo.skeleton.axes) {
      if (axis.order == 0) continue;
      sound = sound && axis.count >= 2;
      for (const SkeletonPoint& point : bamboo.skeleton.points_of(axis)) {
        lowest = std::min(lowest, point.at.z);
        outside = std::max(outside, bamboo.crown.excess_m(point.at));
      }
    }
    for (const LeafSite& leaf : bamboo.skeleton.leaves) {
      lowest = std::min(lowest, leaf.at.z);
      const Point end = leaf.at + leaf.length_m * leaf.along;
      outside = std::max({outside, bamboo.crown.excess_m(leaf.at), bamboo.crown.excess_m(end)});
      sound = sound && std::abs(length(leaf.along) - 1.0) < 1e-12 &&
              std::abs(length(leaf.facing) - 1.0) < 1e-12 &&
              std::abs(dot(leaf.along, leaf.facing)) < 1e-12 &&
              leaf.grade < test::moso().preset().leaves.pictures.size() &&
              leaf.axis < bamboo.skeleton.axes.size();
    }
    CHECK(sound);
    // Crown curves have rounding errors where they are steep; lines below 0.01 mm are not branches.
    CHECK(outside < 1e-5);
    CHECK(lowest == Approx(bamboo.shape.hcb_m).margin(1e-9));
    const CrownRadii& radii = bamboo.shape.radii;
    CHECK(tip_reach_m(bamboo, {1, 0, 0}) == Approx(radii.east_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {-1, 0, 0}) == Approx(radii.west_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {0, -1, 0}) == Approx(radii.south_m).epsilon(1e-9));
    CHECK(tip_reach_m(bamboo, {0, 1, 0}) == Approx(radii.north_m).epsilon(1e-9));
  }
}

TEST_CASE("internodes are short at the base, longest in the middle and short at the top") {
  const CulmStyle style{.internode_length_sd = 0.0};
  Random random(1);
  const std::vector<double> nodes = node_heights_m(style, 14.0, 54, random);
  REQUIRE(nodes.size() == 53);
  std::vector<double> lengths{nodes.front()};
  for (std::size_t i = 1; i < nodes.size(); ++i) lengths.push_back(nodes[i] - nodes[i - 1]);
  lengths.push_back(14.0 - nodes.back());
  const auto longest = std::max_element(lengths.begin(), lengths.end());
  CHECK(static_cast<double>(longest - lengths.begin()) / 54.0 ==
        Approx(style.longest_at).margin(0.02));
  CHECK(std::is_sorted(lengths.begin(), longest));
  CHECK(std::is_sorted(longest, lengths.end(), std::greater<>()));
  // Half an internode from the ends the relative lengths are slightly above those at the ends.
  CHECK(lengths.front() / *longest == Approx(style.internode_base).margin(0.03));
  CHECK(lengths.back() / *longest == Approx(style.internode_top).margin(0.03));
  CHECK(*longest < 0.4);
  CHECK(node_heights_m(style, 2.0, 1, random).empty());
}

TEST_CASE("a culm has the measured number of internodes, with a ridge at each node") {
  Morphology culm = test::usual_culm();
  culm.culm.internodes = 41;
  const test::Bamboo bamboo = test::grown(culm);
  const std::vector<double> ridges = ridges_of(bamboo);
  // All 40 nodes except one at breast height, whose ridge would change the measurement, and the
  // last few, where the culm tapers so fast that it is thicker below the ridge.
  CHECK(ridges.size() >= 37);
  CHECK(ridges.size() <= 40);
  for (const double z : ridges) CHECK(std::abs(z - 1.3) > 0.001);
  // The lowest branches are at a node, which is the crown base.
  CHECK(std::any_of(
      ridges.begin(), ridges.end(), [](double z) { return std::abs(z - 8.0) < 1e-12; }));
  const auto points = culm_of(bamboo);
  const auto at_base = std::find_if(
      points.begin(), points.end(), [](const SkeletonPoint& point) { return point.at.z == 8.0; });
  REQUIRE(at_base != points.end());
  const double even =
      0.005 *
      test::moso().preset().taper.diameters_cm(std::array<double, 1>{8.0}, 14.0, 10.0).front();
  CHECK(at_base->radius_m == Approx(1.05 * even).epsilon(1e-12));
}

TEST_CASE("a culm has the measured bend, as far as its crown allows") {
  Morphology culm = test::usual_culm();
  culm.culm.bend_deg = 1.2;
  culm.culm.bend_azimuth_deg = 90.0;
  const test::Bamboo bamboo = test::grown(culm);
  const auto points = culm_of(bamboo);
  const Point tip = points.back().at;
  // An arch that turns by T leans by T / 2: 6 m tan(0.6 degrees) = 0.0628 m.
  CHECK(tip.x == Approx(6.0 * std::tan(0.6 * std::numbers::pi / 180.0)).epsilon(1e-6));
  CHECK(std::abs(tip.y) < 1e-12);
  for (const SkeletonPoint& point : points) {
    if (point.at.z <= 8.0) CHECK(std::hypot(point.at.x, point.at.y) == 0.0);
  }
  CHECK(bamboo.skeleton.notes.empty());
  culm.culm.bend_deg = 50.0;
  const test::Bamboo bent = test::grown(culm);
  REQUIRE(bent.skeleton.notes.size() == 1);
  CHECK(bent.skeleton.notes.front().about == "bend_deg");
  CHECK(culm_of(bent).back().at.x > tip.x);
}

TEST_CASE("the tip of a culm nods if its bend was not measured") {
  const test::Bamboo bamboo = test::grown(test::usual_culm());
  const auto points = culm_of(bamboo);
  const auto steepness_deg = [&](std::size_t i) {
    const Point step = points[i].at - points[i - 1].at;
    return std::atan2(step.z, std::hypot(step.x, step.y)) * 180.0 / std::numbers::pi;
  };
  // The bow of 0.33 times the radius of 1.3 m, 0.43 m: the derivative of 0.43 m x^6 (1 - x) /
  // 0.05665 at the tip of a crown of 6 m is -1.26: 38 degrees, less what the culm bends otherwise
  // and what the last section, which is not infinitely short, averages.
  CHECK(steepness_deg(points.size() - 1) == Approx(38.0).margin(6.0));
  for (std::size_t i = 1; points[i].at.z < 10.0; ++i) CHECK(steepness_deg(i) > 80.0);
  // The tip leans by at most a fifth of the radius.
  double bow = 0.0;
  for (const SkeletonPoint& point : points) bow = std::max(bow, std::hypot(point.at.x, point.at.y));
  CHECK(bow < 0.33 * 1.3 + 0.2 * 1.3);
  CHECK(bow > 0.2);
}

TEST_CASE("the uppermost branches hang, to the side to which the culm nods") {
  Morphology culm = test::usual_culm();
  culm.culm.bend_deg = 1.0;
  culm.culm.bend_azimuth_deg = 90.0;
  const test::Bamboo bamboo = test::grown(culm);
  int upper = 0;
  int hanging = 0;
  for (const Axis& axis : bamboo.skeleton.axes) {
    const auto points = bamboo.skeleton.points_of(axis);
    if (axis.order != 1 || points.front().at.z < 13.5) continue;
    ++upper;
    const Point to = points.back().at - points.front().at;
    // At 13.5 m, over a crown base of 8 m, they turn by (5.5 / 6)^5 = 0.65 of the way.
    hanging += to.z < 0.0 && to.x > 0.0 ? 1 : 0;
  }
  REQUIRE(upper >= 4);
  CHECK(hanging >= 3 * upper / 4);
}

TEST_CASE("each node has two unequal branches, on alternating sides") {
  const test::Bamboo bamboo = test::grown(test::usual_culm());
  // Bases by height: each height twice, also where the culm bows to the crown's surface.
  std::vector<double> bases;
  for (const Axis& axis : bamboo.skeleton.axes) {
    if (axis.order == 1) bases.push_back(bamboo.skeleton.points_of(axis).front().at.z);
  }
  std::sort(bases.begin(), bases.end());
  const std::set<double> heights(bases.begin(), bases.end());
  CHECK(bases.size() == 2 * heights.size());
  CHECK(heights.size() > 12);
  CHECK(*heights.begin() == 8.0);
  const auto orders = [&](std::uint32_t order) {
    return std::count_if(bamboo.skeleton.axes.begin(),
                         bamboo.skeleton.axes.end(),
                         [order](const Axis& axis) { return axis.order == order; });
  };
  CHECK(orders(2) > 3 * orders(1));
  CHECK(orders(3) == 0);
  CHECK(bamboo.skeleton.leaves.size() > static_cast<std::size_t>(2 * orders(2)));
}

TEST_CASE("the same seed gives the same culm, another seed or name a different one") {
  const test::Bamboo one = test::grown(test::usual_culm());
  const test::Bamboo same = test::grown(test::usual_culm());
  REQUIRE(one.skeleton.points.size() == same.skeleton.points.size());
  bool equal = true;
  for (std::size_t i = 0; i < one.skeleton.points.size(); ++i) {
    const Point off = one.skeleton.points[i].at - same.skeleton.points[i].at;
    equal = equal && length(off) == 0.0;
  }
  CHECK(equal);
  const test::Bamboo other_seed = test::grown(test::usual_culm(), 2);
  const test::Bamboo other_name = test::grown(test::usual_culm("2"));
  CHECK(ridges_of(one) != ridges_of(other_seed));
  CHECK(ridges_of(one) != ridges_of(other_name));
}

TEST_CASE("a culm keeps its nodes when its crown is measured again") {
  const test::Bamboo before = test::grown(test::usual_culm());
  Morphology later = test::usual_culm();
  later.cw_m = 2.9;
  const test::Bamboo after = test::grown(later);
  CHECK(ridges_of(before) == ridges_of(after));
  // Most branches keep their azimuth: all except those that end at a measured radius.
  std::size_t kept = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < before.skeleton.axes.size(); ++i) {
    if (before.skeleton.axes[i].order != 1) continue;
    ++all;
    const auto a = before.skeleton.points_of(before.skeleton.axes[i]);
    for (const Axis& axis : after.skeleton.axes) {
      if (axis.order != 1) continue;
      const auto b = after.skeleton.points_of(axis);
      if (b.front().at.z != a.front().at.z) continue;
      const Point from = direction({a.back().at.x, a.back().at.y, 0.0});
      const Point to = direction({b.back().at.x, b.back().at.y, 0.0});
      if (dot(from, to) > 0.999) {
        ++kept;
        break;
      }
    }
  }
  CHECK(kept >= all - 8);
}

TEST_CASE("leaves are brighter on the sunny side, outside and on outer branches") {
  const test::Bamboo bamboo = test::grown(test::usual_culm());
  const auto& light = test::moso().preset().leaves.light;
  const double sun = test::moso().preset().culm.sun_azimuth_deg;
  REQUIRE(sun == 180.0);
  const auto at = [&](Point place, std::uint32_t order) {
    return leaf_light(light, bamboo.crown, sun, place, order);
  };
  CHECK(at({0, -1, 11}, 2) > at({0, 1, 11}, 2));
  CHECK(at({0, -1, 11}, 2) > at({0, -0.3, 11}, 2));
  CHECK(at({0, -1, 11}, 2) > at({0, -1, 11}, 1));
  CHECK(at({0, -0.3, 13}, 2) > at({0, -0.3, 9}, 2));
  // Grades of all leaves to the south and to the north; most branches of one culm may be on one
  // side.
  double south = 0.0;
  double north = 0.0;
  int souths = 0;
  int norths = 0;
  std::set<std::uint32_t> grades;
  for (int i = 0; i < 30; ++i) {
    for (const LeafSite& leaf : test::grown(test::usual_culm(std::to_string(i))).skeleton.leaves) {
      grades.insert(leaf.grade);
      (leaf.at.y < 0.0 ? south : north) += leaf.grade;
      ++(leaf.at.y < 0.0 ? souths : norths);
    }
  }
  CHECK(grades.size() == test::moso().preset().leaves.pictures.size());
  CHECK(south / souths > north / norths + 0.2);
}
