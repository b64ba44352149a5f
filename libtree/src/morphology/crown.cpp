// SPDX-License-Identifier: MIT
#include "silvafit/tree/crown.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

constexpr int kTableSteps = 128;

/// share^power with the usual powers of crowns written out, because this is the inner loop.
double power_of(double share, double power) {
  if (power == 2.0) return share * share;
  if (power == 3.0) return share * share * share;
  if (power == 1.0) return share;
  return std::pow(share, power);
}

/// share^(1 / index) at equal steps from 0 to 1. Concave, so that straight lines between the steps
/// stay inside the crown. Empty for the index 2, because a square root is as fast as a table.
std::vector<double> width_table(double index) {
  if (index == 2.0) return {};
  std::vector<double> widths(kTableSteps + 1);
  for (int i = 0; i <= kTableSteps; ++i) {
    widths[static_cast<std::size_t>(i)] =
        std::pow(i / static_cast<double>(kTableSteps), 1.0 / index);
  }
  return widths;
}

inline double look_up(const std::vector<double>& widths, double share) {
  if (widths.empty()) return std::sqrt(std::clamp(share, 0.0, 1.0));
  const double at = std::clamp(share, 0.0, 1.0) * kTableSteps;
  // A signed integer of 32 bits, because processors convert it in one instruction.
  const int below = std::min(static_cast<int>(at), kTableSteps - 1);
  const double* const width = widths.data() + below;
  return width[0] + (at - below) * (width[1] - width[0]);
}

/// The largest root in (0, 1] of the function of a ray and a crown curve, starting from u = 1.
/// Newton's steps from there decrease monotonically to the root, because both functions are: convex
/// and increasing for the upper curve, concave and decreasing for the lower one.
template <typename Function>
double root_from_one(Function value_and_slope) {
  constexpr int kSteps = 100;
  double u = 1.0;
  for (int step = 0; step < kSteps; ++step) {
    const auto [value, slope] = value_and_slope(u);
    if (value == 0.0 || slope == 0.0) break;
    const double next = std::max(u - value / slope, 0.0);
    if (!(next < u)) break;
    const bool settled = u - next < 1e-14;
    u = next;
    if (settled) break;
  }
  return u;
}

struct ValueAndSlope {
  double value = 0.0;
  double slope = 0.0;
};

}  // namespace

Crown::Crown(const TreeShape& shape, CrownIndex index)
    : h_m_(shape.h_m), hcb_m_(shape.hcb_m), hc_m_(shape.hc_m), radii_(shape.radii), index_(index) {
  for (const double a : {index.up, index.down}) {
    if (!(a >= 1.0 && a <= 3.0)) throw DomainError("a crown index must be in [1, 3]");
  }
  // A part of the crown without height is never evaluated inside.
  per_up_m_ = h_m_ > hc_m_ ? 1.0 / (h_m_ - hc_m_) : 0.0;
  per_down_m_ = hc_m_ > hcb_m_ ? 1.0 / (hc_m_ - hcb_m_) : 0.0;
  widths_up_ = width_table(index.up);
  widths_down_ = width_table(index.down);
}

Crown Crown::unbounded(const TreeShape& shape) {
  Crown crown(shape, {});
  crown.is_bounded_ = false;
  return crown;
}

double Crown::radius_m(double x, double y) const {
  const double xx = x * x;
  const double yy = y * y;
  const double sum = xx + yy;
  if (sum == 0.0) return radii_.east_m;
  const double across = x >= 0.0 ? radii_.east_m : radii_.west_m;
  const double along = y >= 0.0 ? radii_.north_m : radii_.south_m;
  return (across * xx + along * yy) / sum;
}

Point Crown::widest_point(std::size_t direction) const {
  const Point& outward = kMeasured.at(direction);
  return radius_m(outward.x, outward.y) * outward + Point{0.0, 0.0, hc_m_};
}

double Crown::up_m(double distance_m, double radius_m) const {
  return h_m_ - (h_m_ - hc_m_) * power_of(distance_m / radius_m, index_.up);
}

double Crown::down_m(double distance_m, double radius_m) const {
  return hcb_m_ + (hc_m_ - hcb_m_) * power_of(distance_m / radius_m, index_.down);
}

double Crown::relative_width(double z_m) const {
  if (z_m < hcb_m_ || z_m > h_m_) return 0.0;
  if (z_m == hc_m_) return 1.0;
  return z_m > hc_m_ ? std::pow((h_m_ - z_m) / (h_m_ - hc_m_), 1.0 / index_.up)
                     : std::pow((z_m - hcb_m_) / (hc_m_ - hcb_m_), 1.0 / index_.down);
}

double Crown::tabulated_width(double z_m) const {
  if (z_m > hc_m_) return look_up(widths_up_, (h_m_ - z_m) * per_up_m_);
  if (z_m < hc_m_) return look_up(widths_down_, (z_m - hcb_m_) * per_down_m_);
  return 1.0;
}

double Crown::matching_distance_m(double base_m, double angle_rad, double radius_m) const {
  const bool level = angle_rad >= 0.5 * std::numbers::pi;
  const double rise = level ? 0.0 : radius_m / std::tan(angle_rad);
  const double over = h_m_ - hc_m_;
  const double under = hc_m_ - hcb_m_;
  const bool leaves_above = base_m + rise >= hc_m_;
  const double share = root_from_one([&](double u) -> ValueAndSlope {
    const double index = leaves_above ? index_.up : index_.down;
    const double power = power_of(u, index);
    const double slope = u > 0.0 ? index * power / u : 0.0;
    if (leaves_above) return {base_m + rise * u - h_m_ + over * power, rise + over * slope};
    return {base_m + rise * u - hcb_m_ - under * power, rise - under * slope};
  });
  return share * radius_m;
}

double Crown::excess_m(Point point) const {
  if (!is_bounded_) return 0.0;
  const double radius = radius_m(point.x, point.y);
  const double distance = std::hypot(point.x, point.y);
  const double z = std::clamp(point.z, hcb_m_, h_m_);
  const double sideways =
      std::hypot(point.z - z, std::max(distance - relative_width(z) * radius, 0.0));
  if (distance > radius) return sideways;
  // If the curve is nearly horizontal, a tiny distance upward is a large distance sideways.
  const double upright =
      std::max({point.z - up_m(distance, radius), down_m(distance, radius) - point.z, 0.0});
  return std::min(sideways, upright);
}

bool Crown::contains(Point point) const {
  if (!is_bounded_) return true;
  if (!(point.z >= hcb_m_ && point.z <= h_m_)) return false;
  const double xx = point.x * point.x;
  const double yy = point.y * point.y;
  const double squared = xx + yy;
  const double widest = tabulated_width(point.z) * weighted_radii(point, xx, yy);
  return squared * squared * squared <= widest * widest;
}

double Crown::length_inside_m(Point from, Point along, double wanted_m) const {
  if (contains(from + wanted_m * along)) return wanted_m;
  constexpr int kHalvings = 6;
  double inside = 0.0;
  double outside = wanted_m;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (inside + outside);
    (contains(from + middle * along) ? inside : outside) = middle;
  }
  return inside;
}

double Crown::weighted_radii(Point point, double xx, double yy) const {
  const double across = point.x >= 0.0 ? radii_.east_m : radii_.west_m;
  const double along = point.y >= 0.0 ? radii_.north_m : radii_.south_m;
  return across * xx + along * yy;
}

Point Crown::confine(Point point) const {
  if (!is_bounded_) return point;
  point.z = std::clamp(point.z, hcb_m_, h_m_);
  const double xx = point.x * point.x;
  const double yy = point.y * point.y;
  const double squared = xx + yy;
  // The crown's radius here, times the squared distance: most points are inside and need no
  // division.
  const double widest = tabulated_width(point.z) * weighted_radii(point, xx, yy);
  if (squared * squared * squared <= widest * widest) return point;
  const double shrink = widest / (squared * std::sqrt(squared));
  return {point.x * shrink, point.y * shrink, point.z};
}

}  // namespace silvafit::tree
