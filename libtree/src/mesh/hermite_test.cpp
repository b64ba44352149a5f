// SPDX-License-Identifier: MIT
#include "mesh/hermite.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "mesh/moving_frame.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

std::vector<HermiteKnot> random_knots(Random& random, std::size_t count) {
  std::vector<HermiteKnot> knots(count);
  Point at{};
  for (HermiteKnot& knot : knots) {
    at =
        at + Point{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(0.01, 2.0)};
    knot.at = at;
    knot.radius_m = random.uniform(0.0, 0.1);
  }
  set_centripetal_parameters(knots);
  set_rates(knots, direction(knots[1].at - knots[0].at));
  return knots;
}

std::vector<HermitePiece> pieces_of(const std::vector<HermiteKnot>& knots) {
  std::vector<HermitePiece> pieces;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) pieces.emplace_back(knots[i], knots[i + 1]);
  set_monotone_radii(knots, pieces);
  return pieces;
}

void check_same(Point a, Point b, double margin) {
  CHECK(a.x == Approx(b.x).margin(margin));
  CHECK(a.y == Approx(b.y).margin(margin));
  CHECK(a.z == Approx(b.z).margin(margin));
}

}  // namespace

TEST_CASE("a Hermite piece is the cubic with the given ends") {
  // p(t) = (t^3 - t, 2 t^2, 1 - t + 3 t^3) from t = 1 to t = 3.
  const auto place = [](double t) {
    return Point{t * t * t - t, 2 * t * t, 1 - t + 3 * t * t * t};
  };
  const auto rate = [](double t) { return Point{3 * t * t - 1, 4 * t, -1 + 9 * t * t}; };
  const HermiteKnot from{.at = place(1), .parameter = 1, .rate = rate(1)};
  const HermiteKnot to{.at = place(3), .parameter = 3, .rate = rate(3)};
  const HermitePiece piece(from, to);
  for (const double share : {0.0, 0.1, 0.37, 0.5, 0.99, 1.0}) {
    const double t = 1.0 + 2.0 * share;
    // Some ten roundings of numbers up to 80.
    check_same(piece.at(share), place(t), 1e-12);
    check_same(piece.rate(share), 2.0 * rate(t), 1e-12);
  }
}

TEST_CASE("curves are C1 along an axis and follow parabolas and straight lines") {
  Random random(1);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const std::vector<HermiteKnot> knots = random_knots(random, 6);
    for (std::size_t i = 1; i + 1 < knots.size(); ++i) {
      const HermitePiece before(knots[i - 1], knots[i]);
      const HermitePiece after(knots[i], knots[i + 1]);
      check_same(before.at(1.0), after.at(0.0), 1e-12);
      const double left = knots[i].parameter - knots[i - 1].parameter;
      const double right = knots[i + 1].parameter - knots[i].parameter;
      check_same((1.0 / left) * before.rate(1.0), (1.0 / right) * after.rate(0.0), 1e-11);
    }
  }
  // A curve through equidistant points on a straight line is the line at constant speed.
  std::vector<HermiteKnot> straight(5);
  for (std::size_t i = 0; i < straight.size(); ++i) {
    straight[i].at = {1.0 * static_cast<double>(i), 0.0, 2.0 * static_cast<double>(i)};
  }
  set_centripetal_parameters(straight);
  set_rates(straight, direction({1.0, 0.0, 2.0}));
  for (std::size_t i = 0; i + 1 < straight.size(); ++i) {
    const HermitePiece piece(straight[i], straight[i + 1]);
    check_same(piece.at(0.3), straight[i].at + 0.3 * Point{1.0, 0.0, 2.0}, 1e-12);
    CHECK(piece.length_m() == Approx(std::sqrt(5.0)).epsilon(1e-12));
  }
}

TEST_CASE("a curve is always near the points that it passes through") {
  // The inner control points of a piece's Bezier form are at most two thirds of its chord away
  // from its ends, and the curve is in their convex hull.
  Random random(2);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const std::vector<HermiteKnot> knots = random_knots(random, 5);
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const HermitePiece piece(knots[i], knots[i + 1]);
      const double chord = length(knots[i + 1].at - knots[i].at);
      for (int k = 0; k <= 20; ++k) {
        const Point at = piece.at(k / 20.0);
        const double nearest = std::min(length(at - knots[i].at), length(at - knots[i + 1].at));
        CHECK(nearest <= (2.0 / 3.0 + 1e-9) * chord);
      }
    }
  }
}

TEST_CASE("radii between two knots stay between theirs") {
  Random random(3);
  for (int repeat = 0; repeat < 100; ++repeat) {
    const std::vector<HermiteKnot> knots = random_knots(random, 7);
    const std::vector<HermitePiece> pieces = pieces_of(knots);
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const HermitePiece& piece = pieces[i];
      const auto [low, high] = std::minmax(knots[i].radius_m, knots[i + 1].radius_m);
      double last = knots[i].radius_m;
      const double way = knots[i + 1].radius_m - knots[i].radius_m;
      for (int k = 0; k <= 40; ++k) {
        const double radius = piece.radius_m(k / 40.0);
        CHECK(radius >= low - 1e-12);
        CHECK(radius <= high + 1e-12);
        CHECK((radius - last) * way >= -1e-12);
        last = radius;
      }
    }
  }
}

TEST_CASE("a straight cone stays straight for any knots") {
  std::vector<HermiteKnot> knots(4);
  const std::array<double, 4> places{0.0, 0.1, 2.5, 3.0};
  for (std::size_t i = 0; i < knots.size(); ++i) {
    knots[i].at = {places[i], 0.0, places[i]};
    knots[i].radius_m = 0.3 - 0.1 * places[i];
  }
  set_centripetal_parameters(knots);
  set_rates(knots, direction({1.0, 0.0, 1.0}));
  for (const HermitePiece& piece : pieces_of(knots)) {
    for (const double share : {0.0, 0.2, 0.7, 1.0}) {
      const double at = piece.length_m(share) / piece.length_m();
      // The length's rule of five points is exact for the speed along a straight line.
      CHECK(piece.radius_m(at) == Approx(0.3 - 0.1 * piece.at(share).x).margin(1e-12));
    }
  }
}

TEST_CASE("lengths along a curve are those of its fine polygon") {
  Random random(4);
  for (int repeat = 0; repeat < 30; ++repeat) {
    const std::vector<HermiteKnot> knots = random_knots(random, 4);
    for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
      const HermitePiece piece(knots[i], knots[i + 1]);
      double sum = 0.0;
      constexpr int kSteps = 20000;
      for (int k = 0; k < kSteps; ++k) {
        sum += length(piece.at((k + 1.0) / kSteps) - piece.at(1.0 * k / kSteps));
      }
      // Five points integrate the speed of these bends to four digits.
      CHECK(piece.length_m() == Approx(sum).epsilon(5e-4));
      for (const double share : {0.0, 0.2, 0.5, 0.9, 1.0}) {
        CHECK(piece.share_at(piece.length_m(share)) == Approx(share).margin(1e-5));
      }
    }
  }
}

TEST_CASE("frames do not rotate about a plane curve") {
  // A quarter circle in the plane x = 0: a vector orthogonal to the plane stays orthogonal.
  Point sideways{1.0, 0.0, 0.0};
  const auto place = [](double a) { return Point{0.0, std::sin(a), 1.0 - std::cos(a)}; };
  const auto tangent = [](double a) { return Point{0.0, std::cos(a), std::sin(a)}; };
  constexpr int kSteps = 7;
  const double step = 0.5 * std::numbers::pi / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    sideways = carried_on(place(i * step),
                          tangent(i * step),
                          sideways,
                          place((i + 1) * step),
                          tangent((i + 1) * step));
  }
  check_same(sideways, {1.0, 0.0, 0.0}, 1e-14);
  // Also where the curve is straight and has no Frenet frame.
  check_same(carried_on({}, {0, 0, 1}, {0.6, 0.8, 0}, {0, 0, 2}, {0, 0, 1}), {0.6, 0.8, 0}, 1e-15);
}

TEST_CASE("along a helix frames rotate against Frenet's by the integral of its torsion") {
  // Helix of radius a and rise b per radian: torsion b / (a^2 + b^2), length sqrt(a^2 + b^2) per
  // radian. Against Frenet's frame, one that does not turn about the curve falls back by torsion
  // times length.
  constexpr double a = 1.0;
  constexpr double b = 0.4;
  const double speed = std::sqrt(a * a + b * b);
  const auto place = [](double t) { return Point{a * std::cos(t), a * std::sin(t), b * t}; };
  const auto tangent = [&](double t) {
    return (1.0 / speed) * Point{-a * std::sin(t), a * std::cos(t), b};
  };
  const auto normal = [](double t) { return Point{-std::cos(t), -std::sin(t), 0.0}; };
  double error_before = 0.0;
  for (const int steps : {40, 80, 160}) {
    constexpr double whole = 5.0;
    Point sideways = normal(0.0);
    for (int i = 0; i < steps; ++i) {
      const double t = whole * i / steps;
      const double next = whole * (i + 1) / steps;
      sideways = carried_on(place(t), tangent(t), sideways, place(next), tangent(next));
    }
    const Point binormal = cross(tangent(whole), normal(whole));
    const double turned = std::atan2(dot(sideways, binormal), dot(sideways, normal(whole)));
    const double expected =
        std::remainder(-b / (a * a + b * b) * speed * whole, 2.0 * std::numbers::pi);
    const double error = std::abs(std::remainder(turned - expected, 2.0 * std::numbers::pi));
    // The method's global error falls with the fourth power of the step (Wang et al. 2008).
    if (error_before > 0.0) CHECK(error_before / error == Approx(16.0).epsilon(0.1));
    error_before = error;
  }
  CHECK(error_before < 1e-7);
}
