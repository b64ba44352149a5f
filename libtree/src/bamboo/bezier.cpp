// SPDX-License-Identifier: MIT
#include "bamboo/bezier.hpp"

#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

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

}  // namespace

Point CubicBezier::at(double t) const {
  const double s = 1.0 - t;
  return s * s * s * control[0] + 3.0 * t * s * s * control[1] + 3.0 * t * t * s * control[2] +
         t * t * t * control[3];
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
