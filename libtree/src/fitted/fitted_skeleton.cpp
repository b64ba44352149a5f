// SPDX-License-Identifier: MIT
#include "silvafit/tree/fitted_skeleton.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "fitted/crown_map.hpp"
#include "fitted/fitted_leaves.hpp"
#include "fitted/radius_axes.hpp"
#include "fitted/standing_skeleton.hpp"
#include "segments/affine_map.hpp"
#include "segments/skeleton_line.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::tree {
namespace {

constexpr double kShortest = 0.0005;  // an axis with less than this length in the crown is removed

// A branch keeps its angle to its parent up to this, so that crowns of other proportions are
// filled.
constexpr double kMostTurned = 15.0 * kRadian;

double squared(double value) { return value * value; }

double angle_between(Point a, Point b) { return std::acos(std::clamp(dot(a, b), -1.0, 1.0)); }

/// The smallest rotation that turns one direction into another.
AffineMap turn_between(Point from, Point to) {
  AffineMap turn;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Point unit{axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
    const Point turned = turned_with(unit, from, to);
    turn.a[0][axis] = turned.x;
    turn.a[1][axis] = turned.y;
    turn.a[2][axis] = turned.z;
  }
  return turn;
}

/// Turns and scales what starts at a base so that its chord becomes another one at another base.
AffineMap moved_between(Point chord, Point base, Point to_chord, Point to_base) {
  const double before = length(chord);
  const double after = length(to_chord);
  AffineMap move;
  if (before > 0.0 && after > 0.0) {
    move = scaled(turn_between(direction(chord), direction(to_chord)), after / before);
  }
  move.b = to_base - move.turn(base);
  return move;
}

Point chord_of(std::span<const SkeletonPoint> line) { return line.back().at - line.front().at; }

/// Sections as in the segment builder, by the taper equation. Straight up to breast height and to
/// the crown base; above, the stem keeps its grown bends, in proportion to the crown's width and
/// within its inner third, and returns to the axis at the tip.
std::vector<SkeletonPoint> fitted_stem(const StandingSkeleton& grown,
                                       const CrownMap& map,
                                       const TreeShape& shape,
                                       const Crown& crown,
                                       const Taper& taper) {
  const std::vector<double> heights = section_heights_m(shape.h_m);
  const std::vector<double> radii = taper.radii_m(heights, shape.h_m, shape.dbh_cm);
  // The height of a section; the stem is on the axis below.
  const double from =
      *std::lower_bound(heights.begin(), heights.end(), std::max(kBreastHeight, shape.hcb_m));
  const double scale = 0.5 * shape.radii.width_m() / map.widest();
  const Point lowest = at_height(grown.course, map.grown_height(from)).at;
  const Point highest = at_height(grown.course, map.grown_height(shape.h_m)).at;

  const auto bent = [&](double z_m) -> Point {
    if (z_m <= from || z_m >= shape.h_m) return {0.0, 0.0, z_m};
    const double share = (z_m - from) / (shape.h_m - from);
    const Point grown_at = at_height(grown.course, map.grown_height(z_m)).at;
    // Both ends stay on the axis.
    const Point chord = lowest + share * (highest - lowest);
    const double x = scale * (grown_at.x - chord.x);
    const double y = scale * (grown_at.y - chord.y);
    const double away = std::hypot(x, y);
    // The inner third of the crown, and no steeper bend than a short crown allows.
    constexpr double kInner = 1.0 / 3.0;
    constexpr double kSteepest = 0.2;
    const double most = std::min(kInner * shape.radii.narrowest_m() * crown.relative_width(z_m),
                                 kSteepest * (shape.h_m - from) * 4.0 * share * (1.0 - share));
    const double kept = away > 0.0 ? most / (most + away) : 0.0;
    return {kept * x, kept * y, z_m};
  };

  std::vector<SkeletonPoint> stem;
  stem.reserve(heights.size());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    stem.push_back({bent(heights[i]), radii[i]});
  }
  return stem;
}

class Fitter {
 public:
  Fitter(StandingSkeleton grown,
         const TreeShape& shape,
         const Crown& crown,
         const Taper& taper,
         double head)
      : grown_(std::move(grown)),
        head_(head),
        crown_(crown),
        map_(grown_, crown),
        stem_(fitted_stem(grown_, map_, shape, crown, taper)) {}

  Skeleton run() {
    radius_axes_ = lead_to_radii(grown_.skeleton, map_, crown_);
    const Skeleton& grown = grown_.skeleton;
    choose_lowest();
    mark_bearers();
    number_.assign(grown.axes.size(), kNone);
    thickness_.assign(grown.axes.size(), 1.0);
    result_.notes = grown.notes;
    result_.axes.reserve(grown.axes.size());
    result_.points.reserve(grown.points.size() + stem_.size());
    number_[0] = result_.add_axis(0, 0, stem_);
    moves_.resize(grown.axes.size());
    turns_.resize(grown.axes.size());
    for (std::uint32_t i = 1; i < grown.axes.size(); ++i) add(i);
    result_.leaves = fitted_leaves(grown, result_, number_, crown_, [this](Point at) {
      const CrownPlace place = map_.place_of(at);
      return bent_with_stem(place, map_.inside(place));
    });
    return std::move(result_);
  }

 private:
  /// The branch of the stem that will start at the crown base: the lowest that is drawn as wood,
  /// and if possible one that reaches no measured radius.
  void choose_lowest() {
    const Skeleton& grown = grown_.skeleton;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 1; i < grown.axes.size(); ++i) {
      const SkeletonPoint& base = grown.points[grown.axes[i].first];
      if (grown.axes[i].order != 1) continue;
      const double reluctance =
          (base.radius_m > 0.0 ? 0.0 : 4.0) + (radius_axes_.direction_of(i) < 0 ? 0.0 : 2.0);
      const double here = reluctance + base.at.z / grown_.top;
      if (here >= least) continue;
      lowest_ = i;
      least = here;
    }
  }

  /// The axes that end at a measured radius and their parents are kept.
  void mark_bearers() {
    const Skeleton& grown = grown_.skeleton;
    bears_radius_.assign(grown.axes.size(), false);
    for (std::uint32_t i = 1; i < grown.axes.size(); ++i) {
      if (radius_axes_.direction_of(i) < 0) continue;
      for (std::uint32_t k = i; k != 0; k = grown.axes[k].parent) bears_radius_[k] = true;
    }
  }

  std::span<const SkeletonPoint> line_of(std::uint32_t axis) const {
    return grown_.skeleton.points_of(grown_.skeleton.axes[axis]);
  }

  std::span<const SkeletonPoint> fitted_line_of(std::uint32_t axis) const {
    return result_.points_of(result_.axes[number_[axis]]);
  }

  /// With the stem's bend: full at the stem, none at the crown's surface.
  Point bent_with_stem(const CrownPlace& place, Point at) const {
    const Point stem = at_height(stem_, at.z).at;
    at.x += (1.0 - place.out) * stem.x;
    at.y += (1.0 - place.out) * stem.y;
    return at;
  }

  void add(std::uint32_t i) {
    const Axis& axis = grown_.skeleton.axes[i];
    if (number_[axis.parent] == kNone) return;
    const int side = radius_axes_.direction_of(i);
    const bool is_measured = i == lowest_ || bears_radius_[i];
    const std::optional<double> start = side >= 0 ? start_of_radius_m(i) : std::nullopt;
    if (head_ > 0.0 && axis.order == 1) {
      arch_from_head(i, side);
    } else if (start) {
      lead_to_radius(i, *start);
    } else if (side >= 0) {
      bend_to_measurement(i);
    } else {
      keep_angle_and_fit_in(i);
      if (is_measured && line_length_m(line_) < kShortest) bend_to_measurement(i);
    }
    if (side >= 0) line_.back() = {radius_tip(side), 0.0};
    if (line_length_m(line_) < kShortest) {
      if (!is_measured) return;
      // An axis of radius 0 on which a measurement depends becomes a shoot along the stem.
      line_.back().at.z += 0.5 * (crown_.h_m() - line_.back().at.z);
    }
    set_radii(i);
    turns_[i] = turn_between(direction(chord_of(line_of(i))), direction(chord_of(line_)));
    number_[i] = result_.add_axis(axis.order, number_[axis.parent], line_);
  }

  /// The axis after the map of the crown and the changes of its parent.
  void place(std::uint32_t i, bool is_bent) {
    const Axis& axis = grown_.skeleton.axes[i];
    const auto grown_line = line_of(i);
    moves_[i] = moves_[axis.parent];
    line_.clear();
    for (std::uint32_t k = 0; k < axis.count; ++k) {
      const CrownPlace place = radius_axes_.led(map_.place_of(grown_line[k].at), axis.first + k);
      const Point at = is_bent ? map_.inside(place) : moves_[i](map_.at(place));
      line_.push_back({bent_with_stem(place, at), grown_line[k].radius_m});
    }
  }

  /// The point on its parent where an axis starts.
  Point base_of(std::uint32_t i) const {
    const Axis& axis = grown_.skeleton.axes[i];
    if (axis.order == 1) {
      if (i == lowest_ && head_ == 0.0) return at_height(stem_, crown_.hcb_m()).at;
      const double z = std::clamp(line_.front().at.z, crown_.hcb_m(), crown_.h_m());
      return crown_.confine(at_height(stem_, z).at);
    }
    const PlaceOnLine place = nearest_place(line_of(axis.parent), line_of(i).front().at);
    const auto parent = fitted_line_of(axis.parent);
    // A crown with very unequal radii is concave between them; the line of a parent may cross it.
    return crown_.confine(between(parent[place.segment], parent[place.segment + 1], place.part).at);
  }

  /// Moves the axis to its base on its parent: as a whole, or so that its tip does not move.
  void bring_to_base(std::uint32_t i, bool keeps_tip) {
    const Point base = base_of(i);
    const Point shift = base - line_.front().at;
    const double total = line_length_m(line_);
    double before = 0.0;
    Point last = line_.front().at;
    for (SkeletonPoint& point : line_) {
      before += length(point.at - last);
      last = point.at;
      const double share = keeps_tip && total > 0.0 ? before / total : 0.0;
      point.at = point.at + squared(1.0 - share) * shift;
      if (keeps_tip) point.at = crown_.confine(point.at);
    }
    line_.front().at = base;
    if (!keeps_tip) moves_[i].b = moves_[i].b + shift;
  }

  /// The direction of the axis if it keeps its angle to its parent.
  Point own_direction(std::uint32_t i) const {
    return turns_[grown_.skeleton.axes[i].parent].turn(direction(chord_of(line_of(i))));
  }

  /// Turns the axis about its base until it has nearly the angle that it grew with.
  void keep_angle(std::uint32_t i) {
    const Point base = line_.front().at;
    const Point own = own_direction(i);
    const Point mapped = direction(chord_of(line_), own);
    const double excess = angle_between(mapped, own) - kMostTurned;
    if (!(excess > 0.0)) return;
    AffineMap turn = turn_about(cross(mapped, own), excess);
    turn.b = base - turn.turn(base);
    for (SkeletonPoint& point : line_) point.at = turn(point.at);
    line_.front().at = base;
    moves_[i] = turn.after(moves_[i]);
  }

  void bend_to_measurement(std::uint32_t i) {
    place(i, true);
    bring_to_base(i, true);
  }

  void keep_angle_and_fit_in(std::uint32_t i) {
    place(i, false);
    bring_to_base(i, false);
    keep_angle(i);
    fit_in(i);
  }

  /// The height at which a branch of the stem to a measured radius starts: where the map has it, or
  /// as near as its angle allows. None if it must bend.
  std::optional<double> start_of_radius_m(std::uint32_t i) {
    if (i == lowest_ || grown_.skeleton.axes[i].order > 1 || head_ > 0.0) return std::nullopt;
    place(i, false);
    const double mapped = base_of(i).z;
    const Point tip = radius_tip(radius_axes_.direction_of(i));
    const double away = std::hypot(tip.x, tip.y);
    const Point own = own_direction(i);
    const double angle = std::atan2(own.z, std::hypot(own.x, own.y));
    constexpr double kSteepest = 85.0 * kRadian;
    const double lowest = tip.z - away * std::tan(std::min(angle + kMostTurned, kSteepest));
    const double highest = tip.z - away * std::tan(std::max(angle - kMostTurned, -kSteepest));
    const double start = std::clamp(mapped, lowest, highest);
    // In a crown that is flat, or narrow for its stem, there is no room for the angle.
    constexpr double kRoom = 4.0;
    const bool has_room = start >= crown_.hcb_m() && start < crown_.h_m() &&
                          away > kRoom * at_height(stem_, start).radius_m;
    return has_room ? std::optional(start) : std::nullopt;
  }

  /// A branch of the stem from its upper part to the surface of the crown: the lower the branch
  /// is, the farther it hangs, and the lowest one to the crown base.
  void arch_from_head(std::uint32_t i, int side) {
    place(i, false);
    const double low_m = crown_.hcb_m();
    const double crown_m = crown_.h_m() - low_m;
    const double share = std::clamp((base_of(i).z - low_m) / crown_m, 0.0, 1.0);
    // Old and young fronds leave the stem close to each other.
    constexpr double kOfRest = 0.2;
    const double start_m = low_m + (head_ + kOfRest * (1.0 - head_) * share) * crown_m;
    if (side >= 0) {
      lead_to(i, start_m, radius_tip(side));
    } else if (i == lowest_) {
      lead_to(i, start_m, {0.0, 0.0, low_m});
      line_.back() = {{0.0, 0.0, low_m}, 0.0};
    } else {
      constexpr double kLowest = 0.12;
      constexpr double kHighest = 0.92;
      const double tip_m = low_m + (kLowest + (kHighest - kLowest) * share) * crown_m;
      const Point out = direction({line_.back().at.x, line_.back().at.y, 0.0}, {1.0, 0.0, 0.0});
      Point tip = crown_.radius_m(out.x, out.y) * crown_.relative_width(tip_m) * out;
      tip.z = tip_m;
      lead_to(i, start_m, crown_.confine(tip));
    }
  }

  /// A branch of the stem ends at a measured radius and keeps its shape.
  void lead_to_radius(std::uint32_t i, double start_m) {
    lead_to(i, start_m, radius_tip(radius_axes_.direction_of(i)));
  }

  /// A branch of the stem ends at a point and keeps its shape.
  void lead_to(std::uint32_t i, double start_m, Point tip) {
    const Point base = crown_.confine(at_height(stem_, start_m).at);
    // Its branches move as the line between its ends does in the map; itself it keeps its shape.
    moves_[i] = moved_between(chord_of(line_), line_.front().at, tip - base, base).after(moves_[i]);
    const auto grown_line = line_of(i);
    const AffineMap move =
        moved_between(chord_of(grown_line), grown_line.front().at, tip - base, base);
    for (std::size_t k = 0; k < grown_line.size(); ++k) {
      line_[k].at = crown_.confine(move(grown_line[k].at));
    }
    line_.front().at = base;
  }

  /// Turns the axis up or down about its base, and shortens it, until it is inside the crown.
  void fit_in(std::uint32_t i) {
    const Point base = line_.front().at;
    const Point chord = line_.back().at - base;
    const Point level = direction(cross(chord, {0.0, 0.0, 1.0}), {1.0, 0.0, 0.0});
    double kept = share_inside(base, {});
    AffineMap best{};
    bool is_turned = false;
    // A turn is better than a cut, but a third of a right angle only for a quarter of the length.
    constexpr double kWorthTurning = 0.85;
    constexpr double kStep = std::numbers::pi / 12.0;
    constexpr double kLossPerStep = 0.12;
    if (kept < kWorthTurning) {
      double most = kept;
      for (int step = 1; step <= 3; ++step) {
        for (const double sign : {1.0, -1.0}) {
          const AffineMap turn = turn_about(level, sign * step * kStep);
          const double share = share_inside(base, turn);
          if (share - kLossPerStep * step <= most) continue;
          most = share - kLossPerStep * step;
          kept = share;
          best = turn;
          is_turned = true;
        }
      }
    }
    if (kept < 1.0) {
      // If all tips ended on the curve, the crown would look like a clipped hedge.
      constexpr double kGoldenRatio = 0.6180339887498949;
      constexpr double kRagged = 0.12;
      kept *= 1.0 - kRagged * std::fmod(kGoldenRatio * i, 1.0);
    }
    if (kept == 1.0 && !is_turned) return;
    AffineMap move = scaled(best, kept);
    move.b = base - move.turn(base);
    for (SkeletonPoint& point : line_) point.at = crown_.confine(move(point.at));
    line_.front().at = base;
    moves_[i] = move.after(moves_[i]);
  }

  /// Proportion of the axis inside the crown if it is turned about its base.
  double share_inside(Point base, const AffineMap& turn) const {
    double share = 1.0;
    for (const SkeletonPoint& point : line_) {
      const Point away = share * turn.turn(point.at - base);
      if (crown_.contains(base + away)) continue;
      const double wanted = length(away);
      if (wanted == 0.0) continue;
      share *= crown_.length_inside_m(base, (1.0 / wanted) * away, wanted) / wanted;
    }
    return share;
  }

  Point radius_tip(int direction) const {
    return crown_.widest_point(static_cast<std::size_t>(direction));
  }

  /// Radii of a branch of the stem keep their ratio to the stem's radius at its base; its twigs are
  /// scaled with it.
  void set_radii(std::uint32_t i) {
    const Axis& axis = grown_.skeleton.axes[i];
    const double grown_base = line_.front().radius_m;
    double bearer_m = 0.0;
    if (axis.order == 1) {
      bearer_m = at_height(stem_, line_.front().at.z).radius_m;
      const double grown_stem = at_height(grown_.course, line_of(i).front().at.z).radius_m;
      thickness_[i] = grown_stem > 0.0 ? bearer_m / grown_stem : 0.0;
    } else {
      thickness_[i] = thickness_[axis.parent];
      const PlaceOnLine place = nearest_place(line_of(axis.parent), line_of(i).front().at);
      const auto parent = fitted_line_of(axis.parent);
      bearer_m = between(parent[place.segment], parent[place.segment + 1], place.part).radius_m;
    }
    // No branch is thicker than its parent, or too thick for its length in a crown too narrow for
    // the stem.
    constexpr double kThickest = 0.15;
    const double most = std::min(bearer_m, kThickest * line_length_m(line_));
    if (grown_base * thickness_[i] > most) thickness_[i] = most / grown_base;
    const bool has_wood = grown_base > 0.0;
    for (SkeletonPoint& point : line_) {
      point.radius_m = has_wood ? std::max(point.radius_m * thickness_[i], kThinnestWoodM) : 0.0;
    }
    line_.back().radius_m = 0.0;
  }

  StandingSkeleton grown_;
  double head_ = 0.0;
  const Crown& crown_;
  CrownMap map_;
  std::vector<SkeletonPoint> stem_;
  RadiusAxes radius_axes_{};
  std::uint32_t lowest_ = kNone;
  std::vector<bool> bears_radius_{};
  std::vector<std::uint32_t> number_{};  ///< of each grown axis in the result
  std::vector<double> thickness_{};      ///< fitted by grown radius of each axis
  std::vector<AffineMap> moves_{};     ///< displacement of each grown axis from its mapped position
  std::vector<AffineMap> turns_{};     ///< of each grown axis to its direction in the result
  std::vector<SkeletonPoint> line_{};  ///< the axis being fitted
  Skeleton result_{};
};

}  // namespace

Skeleton fit_to_measurements(const Skeleton& grown,
                             const TreeShape& shape,
                             const Crown& crown,
                             const Taper& taper,
                             double head) {
  return Fitter(standing(grown), shape, crown, taper, head).run();
}

}  // namespace silvafit::tree
