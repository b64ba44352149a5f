// SPDX-License-Identifier: MIT
#include "mesh/smooth_mesh_limbs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace silvafit::tree {
namespace {

/// Points closer to each other than this are treated as one.
constexpr double kSamePlace = 1e-6;

/// Direction in which a branch starts: its own, turned towards its parent's, the more they
/// agree.
Point leaving(Point own, Point of_bearer) {
  constexpr double kMost = 0.6;
  const double agreement = 0.5 + 0.5 * dot(own, of_bearer);
  return direction(own + kMost * agreement * of_bearer, own);
}

}  // namespace

Limbs::Limbs(const Skeleton& skeleton)
    : skeleton_(skeleton),
      limb_of_(skeleton.axes.size(), kNone),
      first_of_(skeleton.axes.size(), 0),
      last_of_(skeleton.axes.size(), 0),
      is_needed_(skeleton.axes.size(), false) {
  find_continuations();
  mark_measured();
  limbs_.reserve(skeleton.axes.size());
  knots_.reserve(skeleton.points.size() + 2);
  pieces_.reserve(skeleton.points.size() + 2);
  orders_.reserve(skeleton.points.size() + 2);
  for (std::uint32_t axis = 0; axis < skeleton.axes.size(); ++axis) {
    if (is_wood(axis) && limb_of_[axis] == kNone) add_limb(axis);
  }
}

bool Limbs::is_wood(std::uint32_t axis) const {
  return axis == 0 || skeleton_.points[skeleton_.axes[axis].first].radius_m > 0.0;
}

/// At most one axis continues an axis: the thickest that starts at its end, if it is as thick as
/// the end or slightly thinner.
void Limbs::find_continuations() {
  constexpr double kThickest = 1.05;
  constexpr double kThinnest = 0.6;
  continuation_of_.assign(skeleton_.axes.size(), kNone);
  for (std::uint32_t axis = 1; axis < skeleton_.axes.size(); ++axis) {
    const std::uint32_t parent = skeleton_.axes[axis].parent;
    if (parent == 0 || parent >= axis) continue;
    const SkeletonPoint& end = skeleton_.points_of(skeleton_.axes[parent]).back();
    const SkeletonPoint& base = skeleton_.points[skeleton_.axes[axis].first];
    if (!(end.radius_m > 0.0) || length(base.at - end.at) > 0.1 * end.radius_m) continue;
    if (base.radius_m > kThickest * end.radius_m || base.radius_m < kThinnest * end.radius_m) {
      continue;
    }
    std::uint32_t& next = continuation_of_[parent];
    if (next == kNone || base.radius_m > skeleton_.points[skeleton_.axes[next].first].radius_m) {
      next = axis;
    }
  }
}

void Limbs::mark(std::uint32_t axis) {
  while (axis != 0 && !is_needed_[axis]) {
    is_needed_[axis] = true;
    axis = skeleton_.axes[axis].parent;
  }
}

/// Axes that end at one of the four crown radii, or are the lowest of the crown, are drawn at all
/// levels of detail.
void Limbs::mark_measured() {
  // tan(0.5 degrees), as in measure().
  constexpr double kSector = 0.008726867790758789;
  struct Farthest {
    std::uint32_t axis = 0;
    double reach = 0.0;
  };
  std::array<Farthest, 4> farthest{};
  Farthest lowest{0, std::numeric_limits<double>::infinity()};
  for (std::uint32_t axis = 1; axis < skeleton_.axes.size(); ++axis) {
    if (!is_wood(axis)) continue;
    const auto points = skeleton_.points_of(skeleton_.axes[axis]);
    const Point tip = points.back().at;
    const bool is_east_west = std::abs(tip.y) <= kSector * std::abs(tip.x);
    const bool is_north_south = std::abs(tip.x) <= kSector * std::abs(tip.y);
    if (is_east_west || is_north_south) {
      Farthest& side = is_east_west ? farthest[tip.x > 0.0 ? 0 : 1] : farthest[tip.y > 0.0 ? 2 : 3];
      const double reach = std::hypot(tip.x, tip.y);
      if (reach > side.reach) side = {axis, reach};
    }
    for (const SkeletonPoint& point : points) {
      if (point.at.z < lowest.reach) lowest = {axis, point.at.z};
    }
  }
  for (const Farthest& side : farthest) mark(side.axis);
  mark(lowest.axis);
}

Limbs::Place Limbs::nearest(std::uint32_t axis, Point place) const {
  const auto knots = knots_of(limbs_[limb_of_[axis]]);
  double least = std::numeric_limits<double>::infinity();
  Place nearest{};
  for (std::uint32_t i = first_of_[axis]; i < last_of_[axis]; ++i) {
    const Point along = knots[i + 1].at - knots[i].at;
    const Point from = place - knots[i].at;
    const double share = std::clamp(dot(from, along) / dot(along, along), 0.0, 1.0);
    const Point off = from - share * along;
    const double distance = dot(off, off);
    if (distance < least) {
      least = distance;
      nearest = {i, share};
    }
  }
  return nearest;
}

Limbs::Place Limbs::away_from_ends(const Limb& limb, Place place, double distance_m) const {
  const auto knots = knots_of(limb);
  const auto chord = [&](std::uint32_t i) { return length(knots[i + 1].at - knots[i].at); };
  double below = place.share * chord(place.knot);
  for (std::uint32_t i = 0; i < place.knot && below < distance_m; ++i) below += chord(i);
  double above = (1.0 - place.share) * chord(place.knot);
  for (std::uint32_t i = place.knot + 1; i + 1 < limb.count && above < distance_m; ++i) {
    above += chord(i);
  }
  // Equally far from both ends if the limb is too short.
  double move = 0.0;
  if (limb.axis == 0) {
    // A branch at the base of the stem stays there; the crown base lifts it.
    move = std::max(std::min(above - distance_m, 0.0), -below);
  } else if (below + above < 2.0 * distance_m) {
    move = 0.5 * (above - below);
  } else if (below < distance_m) {
    move = distance_m - below;
  } else if (above < distance_m) {
    move = above - distance_m;
  }
  double along = place.share * chord(place.knot) + move;
  while (along < 0.0 && place.knot > 0) along += chord(--place.knot);
  while (along > chord(place.knot) && place.knot + 2 < limb.count) along -= chord(place.knot++);
  place.share = std::clamp(along / chord(place.knot), 0.0, 1.0);
  return place;
}

HermiteKnot Limbs::on_curve(const Limb& limb, Place place) const {
  const HermitePiece& piece = pieces_[limb.first + place.knot];
  const double share = piece.share_at(place.share * piece.length_m());
  HermiteKnot knot;
  knot.at = piece.at(share);
  knot.radius_m = piece.radius_m(place.share);
  knot.rate = piece.rate(share);
  return knot;
}

Point Limbs::moved(std::uint32_t axis, Point place) const {
  if (limb_of_[axis] == kNone) return {};
  const Limb& limb = limbs_[limb_of_[axis]];
  const Place at = nearest(axis, place);
  const auto knots = knots_of(limb);
  const Point chord = knots[at.knot + 1].at - knots[at.knot].at;
  return on_curve(limb, at).at - (knots[at.knot].at + at.share * chord);
}

std::size_t Limbs::drawn_knots(const Limb& limb, int wood_order) const {
  std::size_t drawn = 1;
  while (drawn < limb.count && static_cast<int>(orders_[limb.first + drawn]) <= wood_order) {
    ++drawn;
  }
  return drawn > 1 ? drawn : 0;
}

void Limbs::add_knot(const SkeletonPoint& point, std::uint32_t order) {
  knots_.push_back({.at = point.at, .radius_m = point.radius_m});
  orders_.push_back(order);
}

/// Points of an axis as knots; on the stem breast height is one.
void Limbs::add_knots(std::uint32_t axis, std::uint32_t order) {
  const auto points = skeleton_.points_of(skeleton_.axes[axis]);
  const bool goes_on = limbs_.back().axis != axis;
  const std::uint32_t first = limbs_.back().first;
  if (!goes_on) add_knot(points.front(), order);
  first_of_[axis] = static_cast<std::uint32_t>(knots_.size()) - first - 1;
  for (const SkeletonPoint& point : points.subspan(1)) {
    const HermiteKnot& before = knots_.back();
    if (axis == 0 && before.at.z < kBreastHeight && point.at.z > kBreastHeight) {
      const double part = (kBreastHeight - before.at.z) / (point.at.z - before.at.z);
      SkeletonPoint measured = between({before.at, before.radius_m}, point, part);
      measured.at.z = kBreastHeight;
      if (part > 0.0) add_knot(measured, order);
    }
    const bool is_breast_height = axis == 0 && knots_.back().at.z == kBreastHeight;
    if (length(point.at - knots_.back().at) > kSamePlace || is_breast_height) {
      add_knot(point, order);
    } else if (knots_.size() > first + 1) {
      knots_.back().at = point.at;
      knots_.back().radius_m = point.radius_m;
    }
  }
  last_of_[axis] = static_cast<std::uint32_t>(knots_.size()) - first - 1;
}

void Limbs::add_limb(std::uint32_t axis) {
  Limb limb{.axis = axis, .first = static_cast<std::uint32_t>(knots_.size())};
  limbs_.push_back(limb);
  const auto number = static_cast<std::uint32_t>(limbs_.size() - 1);
  for (std::uint32_t next = axis; next != kNone; next = continuation_of_[next]) {
    add_knots(next, is_needed_[next] || next == 0 ? 0 : skeleton_.axes[next].order);
    limb_of_[next] = number;
  }
  limb.count = static_cast<std::uint32_t>(knots_.size()) - limb.first;
  if (limb.count < 2) {
    // All points are equal: nothing is drawn, and nothing can start on it.
    knots_.resize(limb.first);
    orders_.resize(limb.first);
    limbs_.pop_back();
    for (std::uint32_t next = axis; next != kNone; next = continuation_of_[next])
      limb_of_[next] = kNone;
    return;
  }
  const std::span<HermiteKnot> knots{knots_.data() + limb.first, limb.count};
  Point start = direction(knots[1].at - knots[0].at);
  if (axis != 0 && limb_of_[skeleton_.axes[axis].parent] != kNone) {
    place_on_bearer(limb, axis);
    const Limb& bearer = limbs_[limb.bearer];
    const HermiteKnot base = on_curve(bearer, {limb.bearer_knot, limb.bearer_share});
    if (length(knots[1].at - base.at) > kSamePlace) knots.front().at = base.at;
    const Point own = direction(knots[1].at - knots[0].at, start);
    start = leaving(own, direction(base.rate, own));
  }
  limbs_.back() = limb;
  set_centripetal_parameters(knots);
  set_rates(knots, start);
  if (axis == 0) {
    for (HermiteKnot& knot : knots) {
      // Sections at breast height and below are horizontal.
      if (knot.at.z <= kBreastHeight) knot.rate = {0.0, 0.0, length(knot.rate)};
    }
  }
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) pieces_.emplace_back(knots[i], knots[i + 1]);
  set_monotone_radii(knots, {pieces_.data() + limb.first, knots.size() - 1});
  pieces_.emplace_back();
}

void Limbs::place_on_bearer(Limb& limb, std::uint32_t axis) {
  const std::uint32_t parent = skeleton_.axes[axis].parent;
  limb.bearer = limb_of_[parent];
  const Limb& bearer = limbs_[limb.bearer];
  const HermiteKnot& first = knots_[limb.first];
  const HermiteKnot& second = knots_[limb.first + 1];
  // The distance of the corners of a triangle with the circle's area.
  constexpr double kCorner = 1.6;
  const double reach = kCorner * first.radius_m;
  const Place place = away_from_ends(bearer, nearest(parent, first.at), reach);
  limb.bearer_knot = place.knot;
  limb.bearer_share = place.share;
  for (std::uint32_t i = 0; i < place.knot; ++i) {
    limb.bearer_along_m += pieces_[bearer.first + i].length_m();
  }
  limb.bearer_along_m += place.share * pieces_[bearer.first + place.knot].length_m();
  const HermiteKnot base = on_curve(bearer, place);
  constexpr double kInside = 0.5;
  if (reach <= kInside * base.radius_m) return;
  const Point chord = second.at - base.at;
  const double sine = length(cross(direction(chord), direction(base.rate)));
  constexpr double kFlattest = 0.3;
  // Well inside the parent on the side where the limb starts, so that it has its full thickness
  // where it is visible.
  constexpr double kWithin = 0.4;
  limb.collar_m =
      std::min(0.5 * length(chord), kWithin * base.radius_m / std::max(sine, kFlattest));
}

}  // namespace silvafit::tree
