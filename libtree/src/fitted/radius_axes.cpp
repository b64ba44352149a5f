// SPDX-License-Identifier: MIT
#include "fitted/radius_axes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// From the point's direction to another, counterclockwise, in [-pi, pi].
double turn_to(const CrownPlace& place, Point direction) {
  return std::atan2(place.x * direction.y - place.y * direction.x,
                    place.x * direction.x + place.y * direction.y);
}

/// A candidate axis for a measured radius.
struct Candidate {
  CrownPlace tip{};
  Point base_at{};
  Point tip_at{};
  std::array<double, 4> costs{};  ///< by direction: the necessary bend
  bool is_taken = false;          ///< it, its parent or one of its branches is already used
};

class Leader {
 public:
  Leader(Skeleton& grown, const CrownMap& map, const Crown& crown)
      : grown_(grown), map_(map), crown_(crown) {
    for (const Axis& axis : grown.axes) {
      const auto line = grown.points_of(axis);
      Candidate one{.tip = map.place_of(line.back().at)};
      one.base_at = map.at(map.place_of(line.front().at));
      one.tip_at = map.at(one.tip);
      candidates_.push_back(one);
    }
    candidates_.front().is_taken = true;
    for (std::uint32_t i = 1; i < candidates_.size(); ++i) {
      for (int d = 0; d < 4; ++d) candidates_[i].costs[d] = cost(i, d);
    }
  }

  /// The axes by direction; those that need the smallest bend are assigned first.
  std::array<std::uint32_t, 4> choose() {
    std::array<std::uint32_t, 4> chosen{kNone, kNone, kNone, kNone};
    for (int round = 0; round < 4; ++round) {
      Choice best;
      for (int d = 0; d < 4; ++d) {
        if (chosen[d] != kNone) continue;
        const Choice here = nearest(d);
        if (best.direction < 0 || here.cost < best.cost) best = here;
      }
      constexpr double kTooMuch = 1.0;
      const bool is_new = best.cost > kTooMuch;
      chosen[best.direction] = is_new ? copied(best.direction) : best.axis;
      if (chosen[best.direction] == kNone) {
        throw GeometryError("no branch of the skeleton has a length and a radius");
      }
      take(chosen[best.direction]);
    }
    return chosen;
  }

 private:
  struct Choice {
    int direction = -1;
    std::uint32_t axis = kNone;
    double cost = std::numeric_limits<double>::infinity();
  };

  /// Only axes drawn as wood end at the measured radius.
  bool has_wood(std::uint32_t axis) const {
    return grown_.points[grown_.axes[axis].first].radius_m > 0.0;
  }

  /// Displacement of the tip relative to the length of the axis. A branch of the stem turns about
  /// the stem without a bend.
  double cost(std::uint32_t axis, int direction) const {
    const Candidate& one = candidates_[axis];
    const Point outward = Crown::kMeasured[direction];
    const double radius = crown_.radius_m(outward.x, outward.y);
    const Point wanted = crown_.widest_point(static_cast<std::size_t>(direction));
    const double size = length(one.tip_at - one.base_at);
    if (!(size > 0.0) || !has_wood(axis)) return std::numeric_limits<double>::infinity();
    if (grown_.axes[axis].order > 1) {
      constexpr double kOfTwig = 0.1;
      return kOfTwig + length(wanted - one.tip_at) / size;
    }
    constexpr double kPerRadian = 0.25;
    const double short_of = radius - std::hypot(one.tip_at.x, one.tip_at.y);
    return std::hypot(short_of, wanted.z - one.tip_at.z) / size +
           kPerRadian * std::abs(turn_to(one.tip, outward));
  }

  Choice nearest(int direction) const {
    Choice best{.direction = direction};
    for (std::uint32_t i = 1; i < candidates_.size(); ++i) {
      if (candidates_[i].is_taken) continue;
      const double here = candidates_[i].costs[direction];
      if (here < best.cost) best = {direction, i, here};
    }
    return best;
  }

  /// Neither the parent of an axis nor its branches are bent again.
  void take(std::uint32_t axis) {
    for (std::uint32_t i = axis; i != 0; i = grown_.axes[i].parent) candidates_[i].is_taken = true;
    std::vector<bool> is_below(grown_.axes.size(), false);
    is_below[axis] = true;
    for (std::uint32_t i = axis + 1; i < grown_.axes.size(); ++i) {
      if (!is_below[grown_.axes[i].parent]) continue;
      is_below[i] = true;
      candidates_[i].is_taken = true;
    }
  }

  /// A copy of the branch that is nearest to the radius after rotation about the stem.
  std::uint32_t copied(int direction) {
    std::uint32_t from = kNone;
    double least = std::numeric_limits<double>::infinity();
    const std::size_t own = grown_.axes.size() - copied_axes_;
    for (std::uint32_t i = 1; i < own; ++i) {
      if (grown_.axes[i].order != 1) continue;
      const Candidate& one = candidates_[i];
      const double size = length(one.tip_at - one.base_at);
      const double gap = std::hypot(
          1.0 - one.tip.out, (one.tip.z_m - crown_.hc_m()) / (crown_.h_m() - crown_.hcb_m()));
      if (size > 0.0 && gap < least && has_wood(i)) {
        least = gap;
        from = i;
      }
    }
    return from == kNone ? kNone
                         : copy(from, turn_to(candidates_[from].tip, Crown::kMeasured[direction]));
  }

  std::uint32_t copy(std::uint32_t branch, double turn_rad) {
    const double c = std::cos(turn_rad);
    const double s = std::sin(turn_rad);
    const auto turned = [c, s](Point p) {
      return Point{c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    };
    const auto own = static_cast<std::uint32_t>(grown_.axes.size());
    std::vector<std::uint32_t> number(own, kNone);
    for (std::uint32_t i = branch; i < own; ++i) {
      const Axis axis = grown_.axes[i];
      if (i != branch && number[axis.parent] == kNone) continue;
      number[i] = grown_.add_axis(axis.order, i == branch ? 0 : number[axis.parent]);
      for (std::uint32_t k = 0; k < axis.count; ++k) {
        const SkeletonPoint point = grown_.points[axis.first + k];
        grown_.add_point(turned(point.at), point.radius_m);
      }
      candidates_.push_back(candidates_[i]);
      candidates_.back().is_taken = true;
      ++copied_axes_;
    }
    candidates_[number[branch]].tip =
        map_.place_of(grown_.points_of(grown_.axes[number[branch]]).back().at);
    const std::size_t leaves = grown_.leaves.size();
    for (std::size_t i = 0; i < leaves; ++i) {
      LeafSite leaf = grown_.leaves[i];
      if (leaf.axis >= own || number[leaf.axis] == kNone) continue;
      leaf.axis = number[leaf.axis];
      leaf.at = turned(leaf.at);
      leaf.along = turned(leaf.along);
      leaf.facing = turned(leaf.facing);
      grown_.leaves.push_back(leaf);
    }
    return number[branch];
  }

  Skeleton& grown_;
  const CrownMap& map_;
  const Crown& crown_;
  std::vector<Candidate> candidates_{};
  std::size_t copied_axes_ = 0;
};

}  // namespace

int RadiusAxes::direction_of(std::uint32_t axis) const {
  for (std::size_t d = 0; d < axes_.size(); ++d) {
    if (axes_[d] == axis) return static_cast<int>(d);
  }
  return -1;
}

CrownPlace RadiusAxes::led(CrownPlace place, std::uint32_t point) const {
  const Lead& lead = leads_[point];
  const double x = lead.turn_cos * place.x - lead.turn_sin * place.y;
  place.y = lead.turn_sin * place.x + lead.turn_cos * place.y;
  place.x = x;
  if (lead.out != 0.0) {
    place.out = std::clamp(place.out + lead.out, 0.0, lead.is_own ? 1.0 : 2.0);
    // Parts beyond the tip of their parent are moved inward, so that they stay in the crown.
    constexpr double kKnee = 0.85;
    if (place.out > kKnee && !lead.is_own) {
      const double beyond = (place.out - kKnee) / (1.0 - kKnee);
      place.out = kKnee + (1.0 - kKnee) * beyond / (1.0 + beyond);
    }
  }
  place.z_m += lead.rise_m;
  return place;
}

RadiusAxes lead_to_radii(Skeleton& grown, const CrownMap& map, const Crown& crown) {
  RadiusAxes result;
  result.axes_ = Leader(grown, map, crown).choose();
  result.leads_.resize(grown.points.size());
  std::vector<int> direction(grown.axes.size(), -1);
  for (std::uint32_t i = 1; i < grown.axes.size(); ++i) {
    const Axis& axis = grown.axes[i];
    const auto line = grown.points_of(axis);
    const int own = result.direction_of(i);
    if (own >= 0) {
      const CrownPlace tip = map.place_of(line.back().at);
      const double turn = turn_to(tip, Crown::kMeasured[own]);
      const double total = line_length_m(line);
      double before = 0.0;
      for (std::uint32_t k = 0; k < axis.count; ++k) {
        if (k > 0) before += length(line[k].at - line[k - 1].at);
        const double share = total > 0.0 ? before / total : 1.0;
        const double bend = share * share;
        // A branch of the stem turns about the stem as a whole.
        const double turned = axis.order == 1 ? turn : bend * turn;
        result.leads_[axis.first + k] = {std::cos(turned),
                                         std::sin(turned),
                                         bend * (1.0 - tip.out),
                                         bend * (crown.hc_m() - tip.z_m),
                                         true};
      }
      direction[i] = own;
    } else if (direction[axis.parent] >= 0) {
      direction[i] = direction[axis.parent];
      const Axis& parent = grown.axes[axis.parent];
      const PlaceOnLine place = nearest_place(grown.points_of(parent), line.front().at);
      const auto& from = result.leads_[parent.first + place.segment];
      const auto& to = result.leads_[parent.first + place.segment + 1];
      const auto mix = [&](double a, double b) { return a + place.part * (b - a); };
      RadiusAxes::Lead lead{mix(from.turn_cos, to.turn_cos),
                            mix(from.turn_sin, to.turn_sin),
                            mix(from.out, to.out),
                            mix(from.rise_m, to.rise_m)};
      const double size = std::hypot(lead.turn_cos, lead.turn_sin);
      if (size > 0.0) {
        lead.turn_cos /= size;
        lead.turn_sin /= size;
      }
      for (std::uint32_t k = 0; k < axis.count; ++k) result.leads_[axis.first + k] = lead;
    }
  }
  return result;
}

}  // namespace silvafit::tree
