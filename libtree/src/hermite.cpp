// SPDX-License-Identifier: MIT
#include "hermite.hpp"

#include <algorithm>
#include <cmath>

namespace silvafit::tree {
namespace {

double step_of(std::span<const HermiteKnot> knots, std::size_t i) {
  return knots[i + 1].parameter - knots[i].parameter;
}

double radius_slope(std::span<const HermiteKnot> knots, std::size_t i) {
  return (knots[i + 1].radius_m - knots[i].radius_m) / step_of(knots, i);
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
  // No bend at the end: the second derivative is zero there.
  knots[last].rate = 1.5 * before - 0.5 * knots[last - 1].rate;
}

void set_monotone_radius_rates(std::span<HermiteKnot> knots) {
  const std::size_t last = knots.size() - 1;
  double before = radius_slope(knots, 0);
  knots.front().radius_rate = before;
  for (std::size_t i = 1; i < last; ++i) {
    const double after = radius_slope(knots, i);
    double& rate = knots[i].radius_rate;
    if (before * after <= 0.0) {
      rate = 0.0;
    } else {
      // The weighted harmonic mean lies in the region where the cubic is monotone.
      const double left = step_of(knots, i - 1);
      const double right = step_of(knots, i);
      const double w1 = 2.0 * right + left;
      const double w2 = right + 2.0 * left;
      rate = (w1 + w2) / (w1 / before + w2 / after);
    }
    before = after;
  }
  knots[last].radius_rate = before;
}

HermitePiece::HermitePiece(const HermiteKnot& from, const HermiteKnot& to) {
  const double step = to.parameter - from.parameter;
  a_ = from.at;
  b_ = step * from.rate;
  const Point end = step * to.rate;
  const Point chord = to.at - from.at;
  c_ = 3.0 * chord - 2.0 * b_ - end;
  d_ = b_ + end - 2.0 * chord;
  const double r1 = step * from.radius_rate;
  const double r2 = step * to.radius_rate;
  const double change = to.radius_m - from.radius_m;
  radius_ = {from.radius_m, r1, 3.0 * change - 2.0 * r1 - r2, r1 + r2 - 2.0 * change};
  length_m_ = length_m(1.0);
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
  const double enough = 1e-6 * length_m_;
  double share = wanted_m / length_m_;
  double low = 0.0;
  double high = 1.0;
  constexpr int kMost = 20;
  for (int i = 0; i < kMost; ++i) {
    const double off = length_m(share) - wanted_m;
    if (std::abs(off) < enough) break;
    (off > 0.0 ? high : low) = share;
    const double speed = length(rate(share));
    const double next = speed > 0.0 ? share - off / speed : low;
    // Newton's step, or where it leads astray the middle of what is left.
    share = next > low && next < high ? next : 0.5 * (low + high);
  }
  return share;
}

double HermitePiece::steps_within(double tolerance_m) const {
  // The second derivative is linear, so it is largest at an end; between two points of a curve that
  // are a step apart a straight line is off by at most an eighth of it times the step's square.
  const double bend = std::max(length(2.0 * c_), length(2.0 * c_ + 6.0 * d_));
  const double swell =
      std::max(std::abs(2.0 * radius_[2]), std::abs(2.0 * radius_[2] + 6.0 * radius_[3]));
  const double thickest = std::max(radius_[0], radius_m(1.0));
  // Corners stand out, and turn with the curve.
  const double turn = length_m_ > 0.0 ? bend / length_m_ : 0.0;
  return std::sqrt((bend + swell + thickest * turn * turn) / (8.0 * tolerance_m));
}

}  // namespace silvafit::tree
