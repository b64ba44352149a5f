// SPDX-License-Identifier: MIT
#include "mesh/hermite.hpp"

#include <algorithm>
#include <cmath>

namespace silvafit::tree {
namespace {

/// Minimum relative speed at the end of a piece, for the first guess of positions.
constexpr double kSlowest = 1.0 / 3.0;

double step_of(std::span<const HermiteKnot> knots, std::size_t i) {
  return knots[i + 1].parameter - knots[i].parameter;
}

}  // namespace

void set_centripetal_parameters(std::span<HermiteKnot> knots) {
  knots.front().parameter = 0.0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    knots[i].parameter = knots[i - 1].parameter + std::sqrt(length(knots[i].at - knots[i - 1].at));
  }
}

void set_rates(std::span<HermiteKnot> knots, Point start) {
  const auto slope = [&](std::size_t i) {
    return (1.0 / step_of(knots, i)) * (knots[i + 1].at - knots[i].at);
  };
  const std::size_t last = knots.size() - 1;
  Point before = slope(0);
  knots.front().rate = length(before) * start;
  for (std::size_t i = 1; i < last; ++i) {
    const Point after = slope(i);
    const double left = step_of(knots, i - 1);
    const double right = step_of(knots, i);
    knots[i].rate = (1.0 / (left + right)) * (right * before + left * after);
    before = after;
  }
  // Natural end: the second derivative is zero there.
  knots[last].rate = 1.5 * before - 0.5 * knots[last - 1].rate;
}

HermitePiece::HermitePiece(const HermiteKnot& from, const HermiteKnot& to) {
  const double step = to.parameter - from.parameter;
  a_ = from.at;
  b_ = step * from.rate;
  const Point end = step * to.rate;
  const Point chord = to.at - from.at;
  c_ = 3.0 * chord - 2.0 * b_ - end;
  d_ = b_ + end - 2.0 * chord;
  length_m_ = length_m(1.0);
}

void HermitePiece::set_radius(double from_m, double from_slope, double to_m, double to_slope) {
  const double r1 = length_m_ * from_slope;
  const double r2 = length_m_ * to_slope;
  const double change = to_m - from_m;
  radius_ = {from_m, r1, 3.0 * change - 2.0 * r1 - r2, r1 + r2 - 2.0 * change};
}

double HermitePiece::length_m(double share) const {
  constexpr std::array<double, 3> kNodes{0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 3> kWeights{
      0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double half = 0.5 * share;
  double sum = kWeights[0] * length(rate(half));
  for (std::size_t i = 1; i < kNodes.size(); ++i) {
    sum += kWeights[i] *
           (length(rate(half * (1.0 - kNodes[i]))) + length(rate(half * (1.0 + kNodes[i]))));
  }
  return half * sum;
}

double HermitePiece::share_at(double wanted_m) const {
  if (wanted_m <= 0.0) return 0.0;
  if (wanted_m >= length_m_) return 1.0;
  // The position as a cubic of the length with the right slopes at both ends, if the slopes make it
  // monotone.
  const double part = wanted_m / length_m_;
  const double first = length_m_ / std::max(length(rate(0.0)), kSlowest * length_m_);
  const double last = length_m_ / std::max(length(rate(1.0)), kSlowest * length_m_);
  double share = part * (first + part * (3.0 - 2.0 * first - last + part * (first + last - 2.0)));
  const double enough = 1e-6 * length_m_;
  // After a step this small, Newton's method has converged.
  const double nearly = 1e-3 * length_m_;
  double low = 0.0;
  double high = 1.0;
  constexpr int kMost = 20;
  for (int i = 0; i < kMost; ++i) {
    const double off = length_m(share) - wanted_m;
    if (std::abs(off) < enough) break;
    (off > 0.0 ? high : low) = share;
    const double speed = length(rate(share));
    const double next = speed > 0.0 ? share - off / speed : low;
    // If Newton's step leaves the interval, bisection is used.
    const bool is_inside = next > low && next < high;
    share = is_inside ? next : 0.5 * (low + high);
    if (is_inside && std::abs(off) < nearly) break;
  }
  return share;
}

double HermitePiece::steps_within(double tolerance_m) const {
  // The second derivative is linear, so it is largest at an end; the error of a straight line
  // between two points of a curve one step apart is at most an eighth of it times the square of the
  // step.
  const double bend = std::max(length(2.0 * c_), length(2.0 * c_ + 6.0 * d_));
  const double swell =
      std::max(std::abs(2.0 * radius_[2]), std::abs(2.0 * radius_[2] + 6.0 * radius_[3]));
  const double thickest = std::max(radius_[0], radius_m(1.0));
  // Corners are farther out, and turn with the curve.
  const double turn = length_m_ > 0.0 ? bend / length_m_ : 0.0;
  return std::sqrt((bend + swell + thickest * turn * turn) / (8.0 * tolerance_m));
}

void set_monotone_radii(std::span<const HermiteKnot> knots, std::span<HermitePiece> pieces) {
  const auto slope_of = [&](std::size_t i) {
    return (knots[i + 1].radius_m - knots[i].radius_m) / pieces[i].length_m();
  };
  double before = slope_of(0);
  double from_slope = before;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double after = i + 1 < pieces.size() ? slope_of(i + 1) : before;
    double to_slope = before;
    if (before * after <= 0.0) {
      to_slope = i + 1 < pieces.size() ? 0.0 : before;
    } else if (before != after) {
      // The weighted harmonic mean is in the region where the cubic is monotone.
      const double left = pieces[i].length_m();
      const double right = pieces[i + 1].length_m();
      const double w1 = 2.0 * right + left;
      const double w2 = right + 2.0 * left;
      to_slope = (w1 + w2) / (w1 / before + w2 / after);
    }
    pieces[i].set_radius(knots[i].radius_m, from_slope, knots[i + 1].radius_m, to_slope);
    from_slope = to_slope;
    before = after;
  }
}

}  // namespace silvafit::tree
