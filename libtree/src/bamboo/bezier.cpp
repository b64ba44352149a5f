// SPDX-License-Identifier: MIT
#include "bamboo/bezier.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>
#include <string>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

double speed(const CubicBezier& curve, double t) { return length(curve.derivative(t)); }

double quadrature(const CubicBezier& curve, double from, double to) {
  return boost::math::quadrature::gauss<double, 15>::integrate(
      [&curve](double t) { return speed(curve, t); }, from, to);
}

/// \param whole  the quadrature over the whole interval
double halved(const CubicBezier& curve, double from, double to, double whole, int depth) {
  const double middle = 0.5 * (from + to);
  const double left = quadrature(curve, from, middle);
  const double right = quadrature(curve, middle, to);
  constexpr double kDigits = 1e-13;
  if (depth == 0 || std::abs(left + right - whole) <= kDigits * (left + right)) {
    return left + right;
  }
  return halved(curve, from, middle, left, depth - 1) + halved(curve, middle, to, right, depth - 1);
}

void check_parameters(std::span<const Point> points, std::span<const double> parameters) {
  if (parameters.size() != points.size()) {
    throw UsageError("a curve through " + std::to_string(points.size()) +
                     " points needs the same number of parameters, not " +
                     std::to_string(parameters.size()));
  }
  const bool in_order = std::is_sorted(parameters.begin(), parameters.end());
  const bool finite = std::all_of(
      parameters.begin(), parameters.end(), [](double t) { return t >= 0.0 && t <= 1.0; });
  if (!in_order || !finite || parameters.front() != 0.0 || parameters.back() != 1.0) {
    throw UsageError("the parameters of a curve's points must increase from 0 to 1");
  }
}

}  // namespace

std::array<double, 4> bernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * t * s * s, 3.0 * t * t * s, t * t * t};
}

Point CubicBezier::at(double t) const {
  const auto b = bernstein(t);
  return b[0] * control[0] + b[1] * control[1] + b[2] * control[2] + b[3] * control[3];
}

Point CubicBezier::derivative(double t) const {
  const double s = 1.0 - t;
  return 3.0 * s * s * (control[1] - control[0]) + 6.0 * s * t * (control[2] - control[1]) +
         3.0 * t * t * (control[3] - control[2]);
}

double CubicBezier::length_m(double from, double to) const {
  constexpr int kDeepest = 24;
  const double whole = quadrature(*this, from, to);
  return whole == 0.0 ? 0.0 : halved(*this, from, to, whole, kDeepest);
}

std::vector<double> chord_length_parameters(std::span<const Point> points) {
  std::vector<double> parameters(points.size(), 0.0);
  for (std::size_t i = 1; i < points.size(); ++i) {
    parameters[i] = parameters[i - 1] + length(points[i] - points[i - 1]);
  }
  const double total = parameters.empty() ? 0.0 : parameters.back();
  if (!(total > 0.0 && std::isfinite(total))) {
    throw GeometryError("the points of a curve must not all be equal");
  }
  for (double& parameter : parameters) parameter /= total;
  parameters.back() = 1.0;
  return parameters;
}

CubicBezier fit_bezier(std::span<const Point> points, std::span<const double> parameters) {
  if (points.size() < 4) {
    throw GeometryError("a cubic curve needs at least two points between its ends, not " +
                        std::to_string(points.size() < 2 ? 0 : points.size() - 2));
  }
  check_parameters(points, parameters);
  const Point v0 = points.front();
  const Point v3 = points.back();
  double a1 = 0.0;
  double a2 = 0.0;
  double a12 = 0.0;
  Point c1{};
  Point c2{};
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const auto b = bernstein(parameters[i]);
    a1 += b[1] * b[1];
    a2 += b[2] * b[2];
    a12 += b[1] * b[2];
    const Point rest = points[i] - b[0] * v0 - b[3] * v3;
    c1 = c1 + b[1] * rest;
    c2 = c2 + b[2] * rest;
  }
  const double determinant = a1 * a2 - a12 * a12;
  // With a single parameter value the determinant is 0 except for rounding.
  constexpr double kSingular = 1e-12;
  if (!(determinant > kSingular * a1 * a2)) {
    throw GeometryError(
        "the points between a curve's ends do not determine the curve: at least two of them must "
        "have different parameters");
  }
  const double inverse = 1.0 / determinant;
  return {{v0, inverse * (a2 * c1 - a12 * c2), inverse * (a1 * c2 - a12 * c1), v3}};
}

CubicBezier fit_bezier(std::span<const Point> points) {
  if (points.size() < 4) return fit_bezier(points, std::span<const double>{});
  return fit_bezier(points, chord_length_parameters(points));
}

CubicBezier bent_curve(
    Point base, Point along, Point side, double length_m, double bend_deg, double sense) {
  if (!(length_m >= 0.0 && std::isfinite(length_m))) {
    throw UsageError("the length of a curve must not be negative");
  }
  if (!(bend_deg >= 0.0 && bend_deg < 180.0)) {
    throw UsageError("the bend of a curve must be at least 0 and below 180 degrees");
  }
  const double bend = sense == 0.0 ? 0.0 : bend_deg * std::numbers::pi / 180.0;
  const Point towards = sense < 0.0 ? -1.0 * side : side;
  const Point end = std::cos(bend) * along + std::sin(bend) * towards;
  const Point chord = direction(along + end, along);
  // For an arc with a chord of length 1.
  constexpr double kStraight = 1e-6;
  const double handle = bend < kStraight
                            ? 1.0 / 3.0
                            : 4.0 / 3.0 * std::tan(0.25 * bend) / (2.0 * std::sin(0.5 * bend));
  const CubicBezier unit{{Point{}, handle * along, chord - handle * end, chord}};
  const double scale = bend < kStraight ? length_m : length_m / unit.length_m();
  CubicBezier curve;
  for (std::size_t k = 0; k < 4; ++k) curve.control[k] = base + scale * unit.control[k];
  return curve;
}

}  // namespace silvafit::tree
