// SPDX-License-Identifier: MIT
#include "silvafit/tree/crown_meeting.hpp"

#include <algorithm>
#include <cmath>

namespace silvafit::tree {
namespace {

/// Both outlines over the distance x from the first stem.
class Outlines {
 public:
  Outlines(const FacingCrown& first, const FacingCrown& second, double distance_m)
      : first_(first), second_(second), distance_m_(distance_m) {}

  double up_1(double x) const { return first_.ground_m + first_.crown.up_m(x, first_.radius_m); }
  double down_1(double x) const {
    return first_.ground_m + first_.crown.down_m(x, first_.radius_m);
  }
  double up_2(double x) const {
    return second_.ground_m + second_.crown.up_m(distance_m_ - x, second_.radius_m);
  }
  double down_2(double x) const {
    return second_.ground_m + second_.crown.down_m(distance_m_ - x, second_.radius_m);
  }

  /// The interval between the stems where both crowns exist.
  double from() const { return std::max(0.0, distance_m_ - second_.radius_m); }
  double to() const { return std::min(distance_m_, first_.radius_m); }

 private:
  const FacingCrown& first_;
  const FacingCrown& second_;
  double distance_m_;
};

/// The zero between two ends of different sign, by bisection; none for equal signs.
template <typename Function>
std::optional<double> zero_between(double from, double to, Function function) {
  const double at_from = function(from);
  if (at_from == 0.0) return from;
  if (at_from * function(to) > 0.0) return std::nullopt;
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (from + to);
    (function(middle) * at_from > 0.0 ? from : to) = middle;
  }
  return 0.5 * (from + to);
}

struct LowerMeeting {
  CrownMeeting::Kind kind = CrownMeeting::Kind::kUpUpAndDownDown;
  double x = 0.0;
  double z = 0.0;
};

/// A point of the overlap's lower edge: not below a lower curve and not above an upper one.
std::optional<LowerMeeting> lower_meeting(const Outlines& at, double from, double to) {
  constexpr double kRounding = 1e-9;
  const auto lower = zero_between(from, to, [&](double x) { return at.down_1(x) - at.down_2(x); });
  if (lower) {
    const double z = at.down_1(*lower);
    if (z <= std::min(at.up_1(*lower), at.up_2(*lower)) + kRounding) {
      return LowerMeeting{CrownMeeting::Kind::kUpUpAndDownDown, *lower, z};
    }
  }
  const auto low_first =
      zero_between(from, to, [&](double x) { return at.up_1(x) - at.down_2(x); });
  if (low_first) {
    return LowerMeeting{CrownMeeting::Kind::kUpUpAndUpDown, *low_first, at.up_1(*low_first)};
  }
  const auto low_second =
      zero_between(from, to, [&](double x) { return at.up_2(x) - at.down_1(x); });
  if (low_second) {
    return LowerMeeting{CrownMeeting::Kind::kUpUpAndUpDown, *low_second, at.up_2(*low_second)};
  }
  return std::nullopt;
}

}  // namespace

double level_distance_m(const Position& first, const Position& second) {
  return std::hypot(second.x_m - first.x_m, second.y_m - first.y_m);
}

FacingCrown facing(const Crown& crown, const Position& own, const Position& neighbor) {
  return {crown, crown.radius_m(neighbor.x_m - own.x_m, neighbor.y_m - own.y_m), own.z_m};
}

bool overlap(const FacingCrown& first, const FacingCrown& second, double distance_m) {
  return first.radius_m + second.radius_m > distance_m;
}

std::optional<CrownMeeting> crown_meeting(const FacingCrown& first,
                                          const FacingCrown& second,
                                          double distance_m) {
  if (!overlap(first, second, distance_m)) return std::nullopt;
  const Outlines at(first, second, distance_m);
  const double from = at.from();
  const double to = at.to();
  const auto upper = zero_between(from, to, [&](double x) { return at.up_1(x) - at.up_2(x); });
  if (!upper) return std::nullopt;
  const double up = at.up_1(*upper);
  if (up < std::max(at.down_1(*upper), at.down_2(*upper))) return std::nullopt;
  const auto lower = lower_meeting(at, from, to);
  if (!lower) return std::nullopt;
  return CrownMeeting{lower->kind, up, *upper, lower->z, lower->x};
}

Competition competition(const FacingCrown& first, const FacingCrown& second) {
  const double lower = std::min(first.ground_m, second.ground_m);
  Competition result;
  result.horizontal = first.radius_m / second.radius_m;
  result.vertical =
      (first.crown.h_m() + first.ground_m - lower) / (second.crown.h_m() + second.ground_m - lower);
  result.total = 0.5 * (result.horizontal + result.vertical);
  return result;
}

std::optional<bool> first_is_weaker(const Competition& competition) {
  const double product = competition.horizontal * competition.vertical;
  // The second tree's own ratios are the inverses, rounded.
  constexpr double kRounding = 1e-12;
  if (std::abs(product - 1.0) <= kRounding) return std::nullopt;
  return product < 1.0;
}

}  // namespace silvafit::tree
