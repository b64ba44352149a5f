// SPDX-License-Identifier: MIT
#include "windows/eroded_areas.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace silvafit::stand {
namespace {

/// Up to this number of margins, each area is computed.
constexpr std::size_t kFewMargins = 128;
/// The same within a panel: a test of a panel would need five areas.
constexpr std::size_t kFewOfPanel = 5;
/// A kink at position s of a panel from -1 to 1 gives an error of the parabola of at most 4 s (s +
/// 1) <= 8 times the error at the quarter point on the other side: together 8e-5.
constexpr double kAtQuarters = 1e-5;
/// The quarter points of the first panel could miss two kinks; those of this many panels hardly
/// can.
constexpr std::size_t kFirstPanels = 8;
/// A panel this narrow relative to all margins has nearly equal areas.
constexpr double kNarrowest = 1e-9;

/// Three equally spaced margins and their areas.
struct Panel {
  double low_m = 0.0;
  double high_m = 0.0;
  double low_m2 = 0.0;
  double middle_m2 = 0.0;
  double high_m2 = 0.0;

  double middle_m() const { return low_m + (high_m - low_m) / 2.0; }
  double parabola_m2(double margin_m) const {
    const double t = 2.0 * (margin_m - low_m) / (high_m - low_m) - 1.0;
    return middle_m2 + t * (high_m2 - low_m2) / 2.0 +
           t * t * ((high_m2 + low_m2) / 2.0 - middle_m2);
  }
};

/// A margin and its index in the list.
struct Member {
  double margin_m = 0.0;
  std::size_t place = 0;
};

class ErodedAreas {
 public:
  ErodedAreas(const Window& window, const std::vector<double>& margins_m)
      : window_(window), margins_m_(margins_m), areas_m2_(margins_m.size()) {}

  std::vector<double> run();

 private:
  using Members = std::span<const Member>;

  double area_m2(double margin_m) const { return std::max(0.0, window_.eroded_area_m2(margin_m)); }
  Panel panel(double low_m, double high_m, double low_m2, double high_m2) const;
  void fill_one_by_one(Members members);
  void fill_first_panels(Members members);
  void fill(const Panel& panel, Members members);
  /// The members below a margin, which are the first.
  std::size_t count_below(double margin_m, Members members) const;

  const Window& window_;
  const std::vector<double>& margins_m_;
  std::vector<double> areas_m2_;
  double narrowest_m_ = 0.0;
};

std::vector<double> ErodedAreas::run() {
  std::vector<Member> order;
  order.reserve(margins_m_.size());
  for (std::size_t i = 0; i < margins_m_.size(); ++i) order.push_back({margins_m_[i], i});
  std::ranges::sort(order, {}, &Member::margin_m);
  if (order.size() <= kFewMargins) {
    fill_one_by_one(order);
  } else {
    fill_first_panels(order);
  }
  return std::move(areas_m2_);
}

void ErodedAreas::fill_one_by_one(Members members) {
  for (std::size_t i = 0; i < members.size(); ++i) {
    const bool is_same = i > 0 && members[i].margin_m == members[i - 1].margin_m;
    areas_m2_[members[i].place] =
        is_same ? areas_m2_[members[i - 1].place] : area_m2(members[i].margin_m);
  }
}

Panel ErodedAreas::panel(double low_m, double high_m, double low_m2, double high_m2) const {
  Panel panel{.low_m = low_m, .high_m = high_m, .low_m2 = low_m2, .high_m2 = high_m2};
  panel.middle_m2 = area_m2(panel.middle_m());
  return panel;
}

std::size_t ErodedAreas::count_below(double margin_m, Members members) const {
  const auto end = std::ranges::lower_bound(members, margin_m, {}, &Member::margin_m);
  return static_cast<std::size_t>(end - members.begin());
}

void ErodedAreas::fill_first_panels(Members members) {
  const double lowest_m = members.front().margin_m;
  const double extent_m = members.back().margin_m - lowest_m;
  narrowest_m_ = kNarrowest * members.back().margin_m;
  double low_m = lowest_m;
  double low_m2 = area_m2(low_m);
  for (std::size_t i = 1; i <= kFirstPanels; ++i) {
    const bool is_last = i == kFirstPanels;
    const double high_m = is_last ? members.back().margin_m
                                  : lowest_m + extent_m * static_cast<double>(i) / kFirstPanels;
    const std::size_t own = is_last ? members.size() : count_below(high_m, members);
    const double high_m2 = area_m2(high_m);
    fill(panel(low_m, high_m, low_m2, high_m2), members.first(own));
    members = members.subspan(own);
    low_m = high_m;
    low_m2 = high_m2;
  }
}

void ErodedAreas::fill(const Panel& whole, Members members) {
  if (members.size() <= kFewOfPanel || !(whole.high_m > whole.low_m)) {
    fill_one_by_one(members);
    return;
  }
  const double middle_m = whole.middle_m();
  const Panel left = panel(whole.low_m, middle_m, whole.low_m2, whole.middle_m2);
  const Panel right = panel(middle_m, whole.high_m, whole.middle_m2, whole.high_m2);
  const double off_m2 = std::max(std::abs(whole.parabola_m2(left.middle_m()) - left.middle_m2),
                                 std::abs(whole.parabola_m2(right.middle_m()) - right.middle_m2));
  // The area decreases, so that it is smallest at the high end.
  const bool holds = off_m2 <= kAtQuarters * whole.high_m2;
  if (holds || whole.high_m - whole.low_m <= narrowest_m_) {
    for (const Member& member : members) {
      areas_m2_[member.place] = std::max(0.0, whole.parabola_m2(member.margin_m));
    }
    return;
  }
  const std::size_t own = count_below(middle_m, members);
  fill(left, members.first(own));
  fill(right, members.subspan(own));
}

}  // namespace

std::vector<double> eroded_areas_m2(const Window& window, const std::vector<double>& margins_m) {
  return ErodedAreas(window, margins_m).run();
}

}  // namespace silvafit::stand
