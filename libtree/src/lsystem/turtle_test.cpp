// SPDX-License-Identifier: MIT
#include "silvafit/tree/turtle.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "reference.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

constexpr double kRadian = std::numbers::pi / 180.0;
// Coordinates of a few meters, a few roundings each.
constexpr double kRounding = 1e-14;

Drawing drawn(const Grammar& grammar, std::optional<int> iterations = {}) {
  Random random(1);
  return draw(grammar.derive(random, iterations), grammar.turtle(), grammar.file());
}

Drawing drawn(const std::string& text, std::optional<int> iterations = {}) {
  return drawn(Grammar::parse(text, "g"), iterations);
}

Skeleton skeleton(const std::string& text, std::optional<std::uint32_t> bud_grade = {}) {
  return skeleton_of(drawn(text), "g", bud_grade);
}

void check_at(Point point, Point expected) {
  CHECK(point.x == Approx(expected.x).margin(kRounding));
  CHECK(point.y == Approx(expected.y).margin(kRounding));
  CHECK(point.z == Approx(expected.z).margin(kRounding));
}

std::string failure(const std::string& text, LsystemLimits limits = {}) {
  const Grammar grammar = Grammar::parse(text, "g");
  Random random(1);
  const ModuleString string = grammar.derive(random);
  try {
    static_cast<void>(skeleton_of(draw(string, grammar.turtle(), "g", limits), "g"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("turns have the direction of their names") {
  // Upright, seen from the south: left is west, the turtle's own up looks at the viewer.
  const auto end = [](const std::string& axiom) {
    return drawn("angle: 90\naxiom: " + axiom).segments.back().to;
  };
  check_at(end("F"), {0, 0, 1});
  check_at(end("+F"), {-1, 0, 0});
  check_at(end("-F"), {1, 0, 0});
  check_at(end("&F"), {0, 1, 0});
  check_at(end("^F"), {0, -1, 0});
  check_at(end("|F"), {0, 0, -1});
  // A roll to the left lowers the left side: up goes to the west, so that down is to the east.
  check_at(end("\\&F"), {1, 0, 0});
  check_at(end("/&F"), {-1, 0, 0});
  check_at(end("\\+F"), {0, 1, 0});
  check_at(end("-(30)F(2)"), {1, 0, std::sqrt(3.0)});
}

TEST_CASE("a turtle's directions stay at right angles after many turns") {
  Random random(7);
  TurtleFrame frame;
  for (int i = 0; i < 100'000; ++i) {
    const double angle = random.uniform(-4.0, 4.0);
    switch (random.below(5)) {
      case 0:
        frame.turn_left(angle);
        break;
      case 1:
        frame.pitch_down(angle);
        break;
      case 2:
        frame.roll_left(angle);
        break;
      case 3:
        frame.bend_towards({0, 0, -1}, angle);
        break;
      default:
        frame.level();
    }
  }
  CHECK(length(frame.heading) == Approx(1).margin(1e-12));
  CHECK(length(frame.left) == Approx(1).margin(1e-12));
  CHECK(length(frame.up) == Approx(1).margin(1e-12));
  CHECK(std::abs(dot(frame.heading, frame.left)) < 1e-12);
  CHECK(std::abs(dot(frame.heading, frame.up)) < 1e-12);
  CHECK(std::abs(dot(frame.left, frame.up)) < 1e-12);
  CHECK(length(frame.up - cross(frame.heading, frame.left)) < 1e-12);
}

TEST_CASE("a full circle of turns is the identity, and opposite turns cancel") {
  TurtleFrame frame;
  for (int i = 0; i < 360; ++i) frame.turn_left(kRadian);
  check_at(frame.heading, {0, 0, 1});
  frame.pitch_down(0.3);
  frame.roll_left(0.7);
  frame.turn_left(1.1);
  frame.turn_left(-1.1);
  frame.roll_left(-0.7);
  frame.pitch_down(-0.3);
  check_at(frame.heading, {0, 0, 1});
  check_at(frame.left, {-1, 0, 0});
  check_at(frame.up, {0, -1, 0});
}

TEST_CASE("$ makes left horizontal and up point upward") {
  TurtleFrame frame;
  frame.pitch_down(1.0);
  frame.roll_left(0.8);
  frame.turn_left(0.4);
  const Point heading = frame.heading;
  frame.level();
  CHECK(std::abs(frame.left.z) < kRounding);
  CHECK(frame.up.z > 0.0);
  check_at(frame.heading, heading);
  TurtleFrame upright;
  upright.level();
  check_at(upright.left, {-1, 0, 0});
}

TEST_CASE("the three-dimensional Hilbert curve visits every cell of a cube once") {
  // ABOP, figure 1.19. With a single wrong turn, cells are visited twice.
  const std::string hilbert =
      "angle: 90\n"
      "axiom: A\n"
      "A -> B-F+CFC+F-D&F^D-F+&&CFC+F+B//\n"
      "B -> A&F^CFB^F^D^^-F-D^|F^B|FC^F^A//\n"
      "C -> |D^|F^B-F+C^F^A&&FA&F^C+F+B^F^D//\n"
      "D -> |CFB-F+B|FA&F^A&&FB-F+B|FC//\n";
  for (int n = 1; n <= 3; ++n) {
    const Drawing drawing = drawn(hilbert, n);
    const std::size_t side = 1U << static_cast<unsigned>(n);
    REQUIRE(drawing.segments.size() == side * side * side - 1);
    std::set<std::tuple<long, long, long>> places{{0, 0, 0}};
    for (const DrawnSegment& segment : drawing.segments) {
      places.emplace(
          std::lround(segment.to.x), std::lround(segment.to.y), std::lround(segment.to.z));
      CHECK(std::abs(segment.to.x - std::round(segment.to.x)) < 1e-12);
    }
    CHECK(places.size() == side * side * side);
    long lowest = 0;
    long highest = 0;
    for (const auto& [x, y, z] : places) {
      lowest = std::min({lowest, z});
      highest = std::max({highest, z});
    }
    CHECK(highest - lowest + 1 == static_cast<long>(side));
  }
}

TEST_CASE("the Koch island is closed") {
  const Drawing drawing = drawn("angle: 90\naxiom: F-F-F-F\nF -> F-F+F+FF-F-F+F", 3);
  CHECK(drawing.segments.size() == 2048);
  CHECK(length(drawing.segments.back().to) < 1e-10);
}

TEST_CASE("the paper's tree has the coordinates computed by hand") {
  const Grammar grammar = Grammar::load(test::source_file("models/grammars/honda.lsys"));
  const Skeleton first = skeleton_of(drawn(grammar, 1), "honda");
  REQUIRE(first.axes.size() == 1);
  REQUIRE(first.points.size() == 2);
  check_at(first.points[0].at, {0, 0, 0});
  check_at(first.points[1].at, {0, 0, 1});
  CHECK(first.points[0].radius_m == 0.05);

  // Step 2: the stem goes on with 0.8; the first branch of 0.67 leaves it at 45 degrees to the
  // north, since down is away from the turtle's up in the south. Widths 0.1 and 0.045.
  const Skeleton second = skeleton_of(drawn(grammar, 2), "honda");
  REQUIRE(second.axes.size() == 2);
  const double half = std::sqrt(0.5);
  const auto stem = second.points_of(second.axes[0]);
  REQUIRE(stem.size() == 3);
  check_at(stem[2].at, {0, 0, 1.8});
  CHECK(stem[0].radius_m == 0.05);
  CHECK(stem[1].radius_m == Approx(0.0225).margin(kRounding));
  CHECK(stem[2].radius_m == 0.0);
  CHECK(second.axes[1].order == 1);
  CHECK(second.axes[1].parent == 0);
  const auto branch = second.points_of(second.axes[1]);
  REQUIRE(branch.size() == 2);
  check_at(branch[0].at, {0, 0, 1});
  check_at(branch[1].at, {0, 0.67 * half, 1 + 0.67 * half});
  CHECK(branch[0].radius_m == Approx(0.0225).margin(kRounding));

  // Step 3: four more segments. The branch goes on straight with 0.67 * 0.8 and bears a lateral
  // branch of 0.67 * 0.67, turned 54 degrees to the right, which is east. The stem's next branch,
  // of 0.8 * 0.67, has rolled 62 degrees to the right: from north by 62 degrees to the west.
  const Skeleton third = skeleton_of(drawn(grammar, 3), "honda");
  REQUIRE(third.axes.size() == 4);
  check_at(third.points_of(third.axes[0]).back().at, {0, 0, 1 + 0.8 + 0.64});
  const auto longer = third.points_of(third.axes[1]);
  REQUIRE(longer.size() == 3);
  check_at(longer[2].at, {0, 1.206 * half, 1 + 1.206 * half});
  const auto lateral = third.points_of(third.axes[2]);
  CHECK(third.axes[2].order == 2);
  CHECK(third.axes[2].parent == 1);
  check_at(lateral[0].at, branch[1].at);
  const double s54 = std::sin(54 * kRadian);
  const double c54 = std::cos(54 * kRadian);
  check_at(lateral[1].at - lateral[0].at, {0.4489 * s54, 0.4489 * c54 * half, 0.4489 * c54 * half});
  CHECK(lateral[0].radius_m == Approx(0.05 * 0.45 * 0.45).margin(kRounding));
  const auto next = third.points_of(third.axes[3]);
  check_at(next[0].at, {0, 0, 1.8});
  check_at(next[1].at - next[0].at,
           {-0.536 * half * std::sin(62 * kRadian),
            0.536 * half * std::cos(62 * kRadian),
            0.536 * half});
}

TEST_CASE("orders of the paper's tree: an axis of order i bears those of order i + 1") {
  const Grammar grammar = Grammar::load(test::source_file("models/grammars/honda.lsys"));
  const Skeleton tree = skeleton_of(drawn(grammar, 7), "honda");
  // A stem of 7 segments. Each of its first 6 ends in a branch of 1 to 6 segments, and each branch
  // of m segments bears branches of m - 1, ..., 1: 2^(7-1) axes in all, binomial(6, i) of order i.
  CHECK(tree.axes.size() == 64);
  std::array<int, 7> of_order{};
  for (std::size_t i = 0; i < tree.axes.size(); ++i) {
    const Axis& axis = tree.axes[i];
    REQUIRE(axis.order < of_order.size());
    ++of_order[axis.order];
    if (i == 0) continue;
    CHECK(axis.parent < i);
    CHECK(axis.order == tree.axes[axis.parent].order + 1);
    // It begins on its parent.
    const auto bearer = tree.points_of(tree.axes[axis.parent]);
    const Point base = tree.points_of(axis).front().at;
    CHECK(std::any_of(bearer.begin(), bearer.end(), [&](const SkeletonPoint& point) {
      return length(point.at - base) == 0.0;
    }));
  }
  CHECK(of_order == std::array{1, 6, 15, 20, 15, 6, 1});
}

TEST_CASE("segments bend towards the tropism") {
  // ABOP, section 2.2: the angle is the elasticity times the length of heading x tropism. From
  // 90 degrees off the vertical with elasticity 0.2: 0.2 rad down after the first segment.
  const Drawing drawing = drawn("elasticity: 0.2\naxiom: &(90)F F F");
  check_at(drawing.segments[0].to, {0, 1, 0});
  check_at(drawing.segments[1].to, {0, 1 + std::cos(0.2), -std::sin(0.2)});
  const double angle = 0.2 + 0.2 * std::cos(0.2);
  check_at(drawing.segments[2].to - drawing.segments[1].to, {0, std::cos(angle), -std::sin(angle)});
  // Upwards, by the parameters of a module.
  const Drawing upward = drawn("axiom: @(0.3, 0, 0, 1)&(90)F F");
  check_at(upward.segments[1].to, {0, 1 + std::cos(0.3), std::sin(0.3)});
}

TEST_CASE("width, default steps and moves") {
  const Drawing drawing = drawn("length: 2\nwidth: 0.4\nwidth_ratio: 0.5\naxiom: F!F(1)[!(3)F]F");
  REQUIRE(drawing.segments.size() == 4);
  CHECK(drawing.segments[0].width == 0.4);
  CHECK(drawing.segments[1].width == 0.2);
  CHECK(drawing.segments[2].width == 3);
  CHECK(drawing.segments[3].width == 0.2);
  check_at(drawing.segments[3].to, {0, 0, 5});
  // A segment after a move starts a new axis, whose parent is the previous one.
  const Skeleton gap = skeleton("axiom: F F f F F");
  REQUIRE(gap.axes.size() == 2);
  CHECK(gap.points_of(gap.axes[0]).size() == 3);
  check_at(gap.points_of(gap.axes[1])[0].at, {0, 0, 3});
  CHECK(gap.axes[1].order == 1);
}

TEST_CASE("an axis without an apex at its end continues in the thickest of its branches") {
  // A fork: the axis continues in the thicker branch.
  const Skeleton fork = skeleton("axiom: F[+(20)!(0.05)F][-(20)!(0.08)F]");
  REQUIRE(fork.axes.size() == 2);
  CHECK(fork.points_of(fork.axes[0]).size() == 3);
  CHECK(fork.points_of(fork.axes[0]).back().at.x > 0.0);
  CHECK(fork.axes[1].order == 1);
  // An apex that has not drawn yet, or a bud, ends the axis.
  CHECK(skeleton("axiom: F[+(20)F][-(20)F]A").axes.size() == 3);
  CHECK(skeleton("axiom: F[+(20)F][-(20)F]~B").axes.size() == 3);
  // Of equally thick branches, the stem continues in the highest, others in the straightest.
  const Skeleton stem = skeleton("axiom: F[+(10)F][-(40)F F F]");
  CHECK(stem.points_of(stem.axes[0]).size() == 5);
  const Skeleton limb = skeleton("axiom: F[+(90)F[+(40)F F F][-(10)F]]F");
  REQUIRE(limb.axes.size() == 3);
  CHECK(limb.points_of(limb.axes[1]).size() == 3);
  CHECK(limb.points_of(limb.axes[2]).size() == 4);
  // Several stems from the ground.
  const Skeleton shrub = skeleton("axiom: [+(20)F][-(10)F F][&(30)F]");
  REQUIRE(shrub.axes.size() == 3);
  CHECK(shrub.points_of(shrub.axes[0]).size() == 3);
  CHECK(shrub.axes[1].order == 1);
  check_at(shrub.points_of(shrub.axes[2])[0].at, {0, 0, 0});
}

TEST_CASE("leaves and buds have their drawn positions and their axes") {
  const Skeleton tree = skeleton("axiom: F ~L(0.2) [+(90) ~L(0.3, 2) ''F ~L ~B(0.1)] F ~B", 7);
  REQUIRE(tree.leaves.size() == 5);
  check_at(tree.leaves[0].at, {0, 0, 1});
  check_at(tree.leaves[0].along, {0, 0, 1});
  check_at(tree.leaves[0].facing, {0, -1, 0});
  CHECK(tree.leaves[0].length_m == 0.2);
  CHECK(tree.leaves[0].axis == 0);
  CHECK(tree.leaves[0].grade == 0);
  // Before the first segment of the branch, leaves belong to the stem.
  CHECK(tree.leaves[1].axis == 0);
  CHECK(tree.leaves[1].grade == 2);
  check_at(tree.leaves[1].along, {-1, 0, 0});
  CHECK(tree.leaves[2].axis == 1);
  CHECK(tree.leaves[2].grade == 2);
  CHECK(tree.leaves[2].length_m == 1.0);
  check_at(tree.leaves[2].at, {-1, 0, 1});
  CHECK(tree.leaves[3].grade == 7);
  CHECK(tree.leaves[3].length_m == 0.1);
  CHECK(skeleton("axiom: F ~L(0.2) ~B").leaves.size() == 1);
}

TEST_CASE("an outline is a leaf from its first corner to its farthest") {
  // The leaf of ABOP figure 1.25: a hexagon in the turtle's plane, of six sides.
  const Skeleton tree = skeleton("angle: 22.5\naxiom: F[&(90)'(3){-f+f+f-|-f+f+f}]");
  REQUIRE(tree.leaves.size() == 1);
  const LeafSite& leaf = tree.leaves[0];
  check_at(leaf.at, {0, 0, 1});
  // -22.5, 0, +22.5 degrees: the tip lies 1 + 2 cos 22.5 degrees ahead.
  check_at(leaf.along, {0, 1, 0});
  CHECK(leaf.length_m == Approx(1 + 2 * std::cos(22.5 * kRadian)).margin(kRounding));
  check_at(leaf.facing, {0, 0, 1});
  CHECK(leaf.grade == 3);
  CHECK(leaf.axis == 0);
  CHECK(tree.points.size() == 2);
}

TEST_CASE("strings that cannot be drawn are refused") {
  CHECK(mentions(failure("axiom: A"), "draws no wood"));
  CHECK(mentions(failure("axiom: F !(-1) F"), "module 2, !(-1): a width"));
  CHECK(mentions(failure("axiom: F ~L(-1)"), "the length of a leaf"));
  CHECK(mentions(failure("axiom: F '(-1)"), "the grade of a leaf"));
  CHECK(mentions(failure("axiom: F(1e300) F(1e300)"), "is farther than"));
  CHECK(mentions(failure("axiom: @(1e300) F"), "a tropism"));
  CHECK(mentions(failure("iterations: 500\naxiom: A\nA -> F[A]", {.depth = 400}),
                 "nested more than 400 levels deep"));
  CHECK(
      mentions(failure("iterations: 1\naxiom: F{A}\nA -> {f}"), "outlines { } must not be nested"));
}
