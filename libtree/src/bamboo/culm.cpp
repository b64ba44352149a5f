// SPDX-License-Identifier: MIT
#include "bamboo/culm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/constants.hpp"
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

namespace {

/// Length of an internode relative to the longest.
double relative_internode(const CulmStyle& style, double share) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  if (share <= style.longest_at) {
    return style.internode_base +
           (1.0 - style.internode_base) * std::sin(kQuarter * share / style.longest_at);
  }
  return style.internode_top +
         (1.0 - style.internode_top) *
             std::cos(kQuarter * (share - style.longest_at) / (1.0 - style.longest_at));
}

}  // namespace

std::vector<double> node_heights_m(const CulmStyle& style,
                                   double h_m,
                                   int internodes,
                                   Random& random) {
  std::vector<double> heights;
  double sum = 0.0;
  for (int i = 0; i < internodes; ++i) {
    const double share = (i + 0.5) / internodes;
    const double factor = style.internode_length_sd > 0.0
                              ? random.truncated_normal(1.0, style.internode_length_sd, 0.5, 1.5)
                              : 1.0;
    sum += factor * relative_internode(style, share);
    heights.push_back(sum);
  }
  heights.pop_back();
  for (double& height : heights) height *= h_m / sum;
  return heights;
}

Culm::Culm(const TreeShape& shape, const Crown& crown, const CulmStyle& style, Random& random)
    : style_(style), h_m_(shape.h_m), hcb_m_(shape.hcb_m), dbh_cm_(shape.dbh_cm) {
  // Drawn even if they were measured, so that later random numbers do not change.
  const double bend_deg = std::clamp(random.normal(style.bend_deg, style.bend_sd_deg), 0.0, 60.0);
  const double azimuth_deg = random.normal(style.sun_azimuth_deg, style.sun_azimuth_sd_deg);
  const double factor = 1.0 + style.internodes_sd * std::clamp(random.normal(), -2.0, 2.0);
  lean_azimuth_deg_ = shape.culm.bend_azimuth_deg.value_or(azimuth_deg);
  const double wanted =
      std::clamp(factor * h_m_ / style.internode_m, 1.0, 1.0 * style.internodes_most);
  const double internodes =
      shape.culm.internodes.value_or(std::max(wanted, 1.0 * style.internodes_least));
  place_nodes(static_cast<int>(std::lround(internodes)), random);
  bend(shape, crown, shape.culm.bend_deg.value_or(bend_deg));
  // Stout culms are stiff.
  constexpr double kSlender = 50.0;
  constexpr double kRoom = 0.33;
  if (shape.culm.bend_deg || 100.0 * h_m_ < kSlender * dbh_cm_) return;
  bow_m_ = std::min(style.nod * (h_m_ - std::max(kBreastHeight, hcb_m_)),
                    kRoom * crown.radii().narrowest_m());
}

void Culm::place_nodes(int internodes, Random& random) {
  for (const double z : node_heights_m(style_, h_m_, internodes, random)) {
    nodes_.push_back({z, static_cast<std::uint32_t>(nodes_.size() + 1)});
  }
  // A bamboo's crown base is its lowest node with branches.
  const auto nearest =
      std::min_element(nodes_.begin(), nodes_.end(), [this](const CulmNode& a, const CulmNode& b) {
        return std::abs(a.z_m - hcb_m_) < std::abs(b.z_m - hcb_m_);
      });
  if (nearest == nodes_.end()) return;
  const double off = std::abs(nearest->z_m - hcb_m_);
  if (off < hcb_m_ && off < h_m_ - hcb_m_) nearest->z_m = hcb_m_;
}

void Culm::bend(const TreeShape& shape, const Crown& crown, double bend_deg) {
  bent_from_m_ = h_m_;
  const double from = std::max(kBreastHeight, hcb_m_);
  const double rise = h_m_ - from;
  constexpr double kShortest = 0.2;
  if (rise < kShortest || bend_deg == 0.0) return;
  // The tip is slightly outside the crown curve, but branches need space around the culm.
  constexpr double kRoom = 0.2;
  const double most_deg = 2.0 * std::atan(kRoom * crown.radii().narrowest_m() / rise) / kRadian;
  if (bend_deg > most_deg && shape.culm.bend_deg) {
    notes_.push_back(
        {"bend_deg",
         fmt::format(
             "bent by {:.1f} degrees instead of {}: the crown is too narrow", most_deg, bend_deg)});
  }
  bent_from_m_ = from;
  const Point side{
      std::sin(lean_azimuth_deg_ * kRadian), std::cos(lean_azimuth_deg_ * kRadian), 0.0};
  const Point base{0.0, 0.0, from};
  const Point up{0.0, 0.0, 1.0};
  const double used_deg = std::min(bend_deg, most_deg);
  const double unit_rise = bent_curve({}, up, side, 1.0, used_deg, 1.0).at(1.0).z;
  curve_ = bent_curve(base, up, side, rise / unit_rise, used_deg, 1.0);
}

/// The culm bows back from its lean and comes forward again at its tip. So it nods although its
/// highest point is the tip.
Point Culm::bow(double z_m) const {
  const double from = std::max(kBreastHeight, hcb_m_);
  const double share = (z_m - from) / (h_m_ - from);
  if (!(share > 0.0)) return {};
  // x^6 (1 - x) is largest at 6/7.
  constexpr double kLargest = 0.05665;
  const double back = -bow_m_ * std::pow(share, 6.0) * (1.0 - share) / kLargest;
  return back *
         Point{std::sin(lean_azimuth_deg_ * kRadian), std::cos(lean_azimuth_deg_ * kRadian), 0.0};
}

Point Culm::at(double z_m) const {
  if (z_m <= bent_from_m_) return Point{0.0, 0.0, z_m} + bow(z_m);
  // Heights increase along the curve, almost uniformly.
  double t = (z_m - bent_from_m_) / (h_m_ - bent_from_m_);
  for (int step = 0; step < 3; ++step) {
    t = std::clamp(t - (curve_.at(t).z - z_m) / curve_.derivative(t).z, 0.0, 1.0);
  }
  const Point found = curve_.at(t);
  return Point{found.x, found.y, z_m} + bow(z_m);
}

std::vector<SkeletonPoint> Culm::points(const Taper& taper) const {
  struct Section {
    double z_m;
    double swelling;
  };
  std::vector<Section> sections{{0.0, 1.0}, {kBreastHeight, 1.0}};
  sections.reserve(3 * nodes_.size() + 3);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const double z = nodes_[i].z_m;
    const double below = i == 0 ? 0.0 : nodes_[i - 1].z_m;
    const double above = i + 1 == nodes_.size() ? h_m_ : nodes_[i + 1].z_m;
    const double half = std::min(style_.ridge_m, 0.2 * std::min(z - below, above - z));
    // Breast height is measured between two nodes.
    constexpr double kLeast = 0.001;
    if (half < kLeast || std::abs(z - kBreastHeight) < half + kLeast) continue;
    sections.insert(sections.end(),
                    {{z - half, 1.0}, {z, 1.0 + style_.ridge_height}, {z + half, 1.0}});
  }
  std::sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) {
    return a.z_m < b.z_m;
  });
  std::vector<double> heights;
  heights.reserve(sections.size());
  for (const Section& section : sections) heights.push_back(section.z_m);
  const std::vector<double> radii = taper.radii_m(heights, h_m_, dbh_cm_);
  std::vector<SkeletonPoint> points;
  points.reserve(sections.size() + 1);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    points.push_back({at(heights[i]), sections[i].swelling * radii[i]});
  }
  points.push_back({at(h_m_), 0.0});
  return points;
}

}  // namespace silvafit::tree
