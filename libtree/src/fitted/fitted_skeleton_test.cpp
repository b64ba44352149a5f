// SPDX-License-Identifier: MIT
#include "silvafit/tree/fitted_skeleton.hpp"

#include "silvafit/base/error.hpp"
#include "test_support/fitted_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;
using namespace silvafit::test;

TEST_CASE("any skeleton can be fitted to the measurements of any valid tree") {
  Random random(51);
  for (const Skeleton& grown : all_kinds()) {
    for (int i = 0; i < 100; ++i) {
      const CrownIndex index{random.uniform(1.0, 2.0), random.uniform(1.0, 2.0)};
      check_fitted(
          fitted(grown, test::random_morphology(random, i), i % 2 == 0 ? CrownIndex{} : index));
    }
  }
}

TEST_CASE("a skeleton without a rising stem or a branch is refused") {
  const auto fit = [](const Skeleton& grown) { return fitted(grown, test::paper_tree_1()); };
  CHECK_THROWS_AS(fit({}), GeometryError);
  HandMade bare;
  bare.axis(0, {{{0, 0, 0}, 1}, {{0, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(bare.take()), GeometryError);
  HandMade lying;
  lying.axis(0, {{{0, 0, 0}, 1}, {{1, 0, 0}, 1}});
  lying.axis(0, {{{0.5, 0, 0}, 1}, {{0.5, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(lying.take()), GeometryError);
  HandMade broken;
  broken.axis(0, {{{0, 0, 0}, 1}, {{0, 0, NAN}, 1}});
  broken.axis(0, {{{0, 0, 0}, 1}, {{1, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(broken.take()), GeometryError);
}

namespace {

/// A tree of usual proportions.
Morphology usual_morphology(Random& random) {
  Morphology tree{.plot = "p", .tree = "t"};
  tree.h_m = random.uniform(6.0, 30.0);
  tree.hcb_m = tree.h_m * random.uniform(0.1, 0.5);
  tree.dbh_cm = tree.h_m * random.uniform(1.0, 2.0);
  const double radius = tree.h_m * random.uniform(0.1, 0.25);
  const auto varied = [&] { return radius * random.uniform(0.75, 1.25); };
  tree.radii = CrownRadii{varied(), varied(), varied(), varied()};
  return tree;
}

double line_length(std::span<const SkeletonPoint> line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += length(line[i].at - line[i - 1].at);
  return sum;
}

double sharpest_bend_deg(std::span<const SkeletonPoint> line) {
  double sharpest = 0.0;
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    const Point before = direction(line[i].at - line[i - 1].at);
    const Point after = direction(line[i + 1].at - line[i].at);
    const double angle = std::acos(std::clamp(dot(before, after), -1.0, 1.0));
    sharpest = std::max(sharpest, angle * 180.0 / std::numbers::pi);
  }
  return sharpest;
}

double share_above(const std::vector<double>& values, double limit) {
  const auto above =
      std::count_if(values.begin(), values.end(), [limit](double value) { return value > limit; });
  return static_cast<double>(above) / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("unit and position of the grown skeleton have no effect") {
  const Skeleton grown = leaning_spiral(0.3);
  Skeleton elsewhere = grown;
  const double unit = 731.0;
  const Point base{12.0, -7.0, 3.0};
  for (SkeletonPoint& point : elsewhere.points) {
    point.at = unit * (point.at + base);
    point.radius_m *= unit;
  }
  for (LeafSite& leaf : elsewhere.leaves) {
    leaf.at = unit * (leaf.at + base);
    leaf.length_m *= unit;
  }
  const Skeleton a = fitted(grown, paper_tree_1()).skeleton;
  const Skeleton b = fitted(elsewhere, paper_tree_1()).skeleton;
  REQUIRE(a.points.size() == b.points.size());
  REQUIRE(a.leaves.size() == b.leaves.size());
  // With coordinates of some thousand units a few of sixteen digits are lost.
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    CHECK(length(a.points[i].at - b.points[i].at) < 1e-6);
    CHECK(a.points[i].radius_m == Approx(b.points[i].radius_m).margin(1e-9));
  }
  for (std::size_t i = 0; i < a.leaves.size(); ++i) {
    CHECK(length(a.leaves[i].at - b.leaves[i].at) < 1e-6);
    // A leaf that is too large for the crown is shortened in steps of a sixty-fourth.
    CHECK(a.leaves[i].length_m == Approx(b.leaves[i].length_m).epsilon(1.0 / 60.0));
  }
}

TEST_CASE("the same skeleton and measurements give the same bytes") {
  const Skeleton grown = Forking(4, 3).grow();
  const Skeleton a = fitted(grown, paper_tree_1()).skeleton;
  const Skeleton b = fitted(grown, paper_tree_1()).skeleton;
  REQUIRE(a.points.size() == b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    REQUIRE(length(a.points[i].at - b.points[i].at) == 0.0);
    REQUIRE(a.points[i].radius_m == b.points[i].radius_m);
  }
}

TEST_CASE("branches of usual trees have no kinks, are not cut and not flattened on the crown") {
  Random random(52);
  for (const double lean : {0.0, 0.4}) {
    const Skeleton grown = leaning_spiral(lean);
    std::vector<double> bends;
    std::vector<double> lengths;
    std::vector<double> places;
    for (int i = 0; i < 100; ++i) {
      const Fitted tree = fitted(grown, usual_morphology(random));
      // Four branches near the four directions: none is copied or lost.
      REQUIRE(tree.skeleton.axes.size() == grown.axes.size());
      double before = 0.0;
      double after = 0.0;
      for (std::size_t k = 1; k < grown.axes.size(); ++k) {
        before += line_length(grown.points_of(grown.axes[k]));
        after += line_length(tree.skeleton.points_of(tree.skeleton.axes[k]));
      }
      for (std::size_t k = 1; k < grown.axes.size(); ++k) {
        const auto line = tree.skeleton.points_of(tree.skeleton.axes[k]);
        bends.push_back(sharpest_bend_deg(line));
        const double scale = line_length(line) / line_length(grown.points_of(grown.axes[k]));
        lengths.push_back(scale * before / after);
        const Point tip = line.back().at;
        const double width = tree.crown.relative_width(tip.z) * tree.crown.radius_m(tip.x, tip.y);
        places.push_back(width > 0.0 ? std::hypot(tip.x, tip.y) / width : 1.0);
      }
    }
    // Five of thirty may be bent: the branch at the crown base, and those that are moved to the
    // measured radii.
    std::vector<double> grown_bends;
    for (std::size_t k = 1; k < grown.axes.size(); ++k) {
      grown_bends.push_back(sharpest_bend_deg(grown.points_of(grown.axes[k])));
    }
    CHECK(share_above(bends, 30.0) < share_above(grown_bends, 30.0) + 5.0 / 30.0);
    CHECK(share_above(bends, 60.0) < 0.05);
    // At both ends, where the crown is narrow, branches may be shorter than half of the others.
    CHECK(1.0 - share_above(lengths, 0.5) < 0.2);
    // Only the four and a few others are exactly on the surface; half are in the outer half.
    CHECK(share_above(places, 0.995) < 0.25);
    CHECK(share_above(places, 0.5) > 0.5);
  }
}

TEST_CASE("a branch keeps its thickness relative to the stem's") {
  // A quarter of the stem's radius at the base, in a sufficiently wide crown.
  HandMade made;
  made.axis(0, {{{0, 0, 0}, 1.0}, {{0, 0, 10}, 0.0}});
  for (int i = 0; i < 12; ++i) {
    const double z = 4.0 + 0.4 * i;
    const Point out{std::cos(2.4 * i), std::sin(2.4 * i), 0.3};
    const double radius = 0.25 * (1.0 - 0.1 * z);
    const auto branch = made.axis(0,
                                  {{{0, 0, z}, radius},
                                   {Point{0, 0, z} + 2.0 * out, 0.5 * radius},
                                   {Point{0, 0, z} + 4.0 * out, 0.1 * radius}});
    made.axis(branch,
              {{Point{0, 0, z} + 2.0 * out, 0.2 * radius}, {Point{0, 0, z + 1} + 2.0 * out, 0.0}});
  }
  const Fitted tree = fitted(made.take(), paper_tree_1());
  const auto stem = tree.skeleton.points_of(tree.skeleton.axes.front());
  for (const Axis& axis : tree.skeleton.axes) {
    if (axis.order != 1) continue;
    const auto line = tree.skeleton.points_of(axis);
    const auto above = std::find_if(stem.begin(), stem.end(), [&](const SkeletonPoint& point) {
      return point.at.z >= line.front().at.z;
    });
    REQUIRE(above != stem.begin());
    const auto below = above - 1;
    const double part = (line.front().at.z - below->at.z) / (above->at.z - below->at.z);
    const double there = below->radius_m + part * (above->radius_m - below->radius_m);
    CHECK(line.front().radius_m == Approx(0.25 * there).epsilon(1e-9));
    CHECK(line[1].radius_m == Approx(0.125 * there).epsilon(1e-9));
  }
  for (std::size_t i = 1; i < tree.skeleton.axes.size(); ++i) {
    const Axis& axis = tree.skeleton.axes[i];
    if (axis.order != 2) continue;
    // A fifth of its branch's base.
    const auto parent = tree.skeleton.points_of(tree.skeleton.axes[axis.parent]);
    CHECK(tree.skeleton.points_of(axis).front().radius_m ==
          Approx(0.2 * parent.front().radius_m).epsilon(1e-9));
  }
}

TEST_CASE("a forked stem continues in the limb that rises highest") {
  HandMade made;
  made.axis(0, {{{0, 0, 0}, 0.3}, {{0, 0, 2}, 0.25}});
  made.axis(0, {{{0, 0, 2}, 0.2}, {{1, 0, 4}, 0.1}, {{2, 0, 5}, 0.0}});
  const auto leader = made.axis(0, {{{0, 0, 2}, 0.2}, {{-0.5, 0, 4}, 0.15}, {{-0.5, 0.2, 7}, 0}});
  made.axis(leader, {{{-0.5, 0, 4}, 0.05}, {{-1.5, 0, 5}, 0.0}});
  const Fitted tree = fitted(made.take(), paper_tree_1());
  check_fitted(tree);
  // Two branches of the stem and copies of them in the directions that have none.
  for (std::size_t i = 1; i < tree.skeleton.axes.size(); ++i) {
    CHECK(tree.skeleton.axes[i].order == 1);
  }
  CHECK(tree.skeleton.axes.size() >= 5);
}

TEST_CASE("a stem keeps its bends above breast height, within the inner third of the crown") {
  HandMade made;
  std::vector<SkeletonPoint> stem;
  for (int i = 0; i <= 40; ++i) {
    const double z = 0.25 * i;
    stem.push_back({{0.4 * std::sin(z), 0.0, z}, 0.2});
  }
  made.axis(0, stem);
  for (int i = 0; i < 16; ++i) {
    const double z = 2.0 + 0.5 * i;
    const Point base{0.4 * std::sin(z), 0.0, z};
    made.axis(0,
              {{base, 0.05}, {base + Point{3 * std::cos(2.4 * i), 3 * std::sin(2.4 * i), 1}, 0}});
  }
  Morphology wide = paper_tree_1();
  wide.hcb_m = 2.0;
  wide.radii = CrownRadii{5, 5, 5, 5};
  const Fitted tree = fitted(made.take(), wide);
  check_stem(tree);
  double left = 0.0;
  double right = 0.0;
  for (const SkeletonPoint& point : tree.skeleton.points_of(tree.skeleton.axes.front())) {
    left = std::min(left, point.at.x);
    right = std::max(right, point.at.x);
    CHECK(std::hypot(point.at.x, point.at.y) <=
          5.0 / 3.0 * tree.crown.relative_width(point.at.z) + 1e-12);
    CHECK(std::abs(point.at.y) < 0.1);
  }
  // It deviates to both sides, by some decimeters in this crown, which is three to five times as
  // wide as the grown one.
  CHECK(left < -0.2);
  CHECK(right > 0.2);
}

TEST_CASE("leaves grow with the crown, but not beyond 0.8 m") {
  const Skeleton grown = leaning_spiral(0.0);
  double before = 0.0;
  for (std::size_t k = 1; k < grown.axes.size(); ++k) {
    before += line_length(grown.points_of(grown.axes[k]));
  }
  Morphology tree = paper_tree_1();
  for (const double scale : {0.3, 1.0, 2.0}) {
    tree.h_m = 20.2 * scale;
    tree.hcb_m = 5.8 * scale;
    tree.hc_m = 8.8 * scale;
    tree.radii = CrownRadii{3 * scale, 3 * scale, 3 * scale, 3 * scale};
    const Fitted one = fitted(grown, tree);
    double after = 0.0;
    for (std::size_t k = 1; k < one.skeleton.axes.size(); ++k) {
      after += line_length(one.skeleton.points_of(one.skeleton.axes[k]));
    }
    std::vector<double> lengths;
    for (const LeafSite& leaf : one.skeleton.leaves) lengths.push_back(leaf.length_m);
    const double longest = *std::max_element(lengths.begin(), lengths.end());
    // Setting the stem straight before makes branches a little longer or shorter.
    CHECK(longest == Approx(std::min(0.2 * after / before, 0.8)).epsilon(0.001));
    CHECK(lengths.size() > grown.leaves.size() * 9 / 10);
  }
}
