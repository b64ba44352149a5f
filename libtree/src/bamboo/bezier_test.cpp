// SPDX-License-Identifier: MIT
#include "bamboo/bezier.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

Point random_point(Random& random) {
  return {random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0), random.uniform(0.0, 12.0)};
}

/// A line of points with increasing parameters; the points are off every cubic.
struct Measured {
  std::vector<Point> points{};
  std::vector<double> parameters{};
};

Measured measured_points(Random& random, int count) {
  Measured measured;
  for (int i = 0; i < count; ++i) {
    measured.points.push_back(random_point(random));
    const double t = i + 1 == count ? 1.0 : (i + (i > 0 ? random.uniform(0.0, 0.9) : 0.0)) / count;
    measured.parameters.push_back(t);
  }
  return measured;
}

}  // namespace

TEST_CASE("the fit recovers a cubic sampled at known parameters") {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const CubicBezier truth{
        {random_point(random), random_point(random), random_point(random), random_point(random)}};
    std::vector<Point> points;
    std::vector<double> parameters;
    const int count = 4 + trial % 9;
    for (int i = 0; i < count; ++i) {
      parameters.push_back(static_cast<double>(i) / (count - 1));
      points.push_back(truth.at(parameters.back()));
    }
    const CubicBezier fitted = fit_bezier(points, parameters);
    for (std::size_t k = 0; k < 4; ++k) {
      // Coordinates up to 12, condition number below 20: only rounding errors.
      CHECK(length(fitted.control[k] - truth.control[k]) < 1e-12 * 12.0);
    }
  }
}

TEST_CASE("the fitted curve solves the normal equations and agrees with a QR solution") {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Measured measured = measured_points(random, 6 + trial % 30);
    const CubicBezier fitted = fit_bezier(measured.points, measured.parameters);
    const auto inner = static_cast<Eigen::Index>(measured.points.size()) - 2;
    Eigen::MatrixX2d design(inner, 2);
    Eigen::MatrixX3d rest(inner, 3);
    Point first{};
    Point second{};
    for (Eigen::Index i = 0; i < inner; ++i) {
      const double t = measured.parameters[static_cast<std::size_t>(i) + 1];
      const Point p = measured.points[static_cast<std::size_t>(i) + 1];
      const double s = 1.0 - t;
      design.row(i) << 3.0 * t * s * s, 3.0 * t * t * s;
      const Point r = p - s * s * s * measured.points.front() - t * t * t * measured.points.back();
      rest.row(i) << r.x, r.y, r.z;
      const Point residual = fitted.at(t) - p;
      first = first + design(i, 0) * residual;
      second = second + design(i, 1) * residual;
    }
    // Sums of up to 34 residuals of a few meters; the gradient is 0 except for rounding.
    CHECK(length(first) < 1e-10);
    CHECK(length(second) < 1e-10);
    const Eigen::Matrix<double, 2, 3> solution = design.colPivHouseholderQr().solve(rest);
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Point v{solution(k, 0), solution(k, 1), solution(k, 2)};
      // The normal equations square the design's condition, which is below 100 here.
      CHECK(length(fitted.control[static_cast<std::size_t>(k) + 1] - v) < 1e-9 * (1 + length(v)));
    }
    CHECK(length(fitted.control[0] - measured.points.front()) == 0.0);
    CHECK(length(fitted.control[3] - measured.points.back()) == 0.0);
  }
}

TEST_CASE("chord-length parameters are shares of the polyline's length") {
  const std::vector<Point> points{{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {3, 4, 5}};
  const std::vector<double> expected{0.0, 3.0 / 12.0, 7.0 / 12.0, 1.0};
  const std::vector<double> parameters = chord_length_parameters(points);
  for (std::size_t i = 0; i < 4; ++i) CHECK(parameters[i] == Approx(expected[i]).margin(1e-15));
  // Points on a straight line at equal distances lie on the cubic of the line.
  std::vector<Point> line;
  for (int i = 0; i <= 7; ++i) line.push_back({0.0, 0.5 * i, 2.0 * i});
  const CubicBezier fitted = fit_bezier(line);
  CHECK(length(fitted.control[1] - Point{0.0, 3.5 / 3.0, 14.0 / 3.0}) < 1e-12);
  CHECK(length(fitted.control[2] - Point{0.0, 7.0 / 3.0, 28.0 / 3.0}) < 1e-12);
}

TEST_CASE("points that do not determine a curve are refused") {
  const std::vector<Point> three{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
  CHECK_THROWS_AS(fit_bezier(three), GeometryError);
  CHECK_THROWS_WITH(fit_bezier(three), Catch::Contains("at least two points between its ends"));
  CHECK_THROWS_AS(fit_bezier(std::vector<Point>{}), GeometryError);
  const std::vector<Point> same(5, Point{1, 1, 1});
  CHECK_THROWS_AS(fit_bezier(same), GeometryError);
  const std::vector<Point> four{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {0, 0, 2}};
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0, 0.3, 0.3, 1}), GeometryError);
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0, 0, 0, 1}), GeometryError);
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0, 0.5, 1}), UsageError);
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0, 0.6, 0.5, 1}), UsageError);
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0.1, 0.5, 0.6, 1}), UsageError);
  CHECK_THROWS_AS(fit_bezier(four, std::vector<double>{0, 0.5, std::nan(""), 1}), UsageError);
}

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
