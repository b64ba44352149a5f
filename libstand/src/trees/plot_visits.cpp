// SPDX-License-Identifier: MIT
#include "trees/plot_visits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "trees/measurement_time.hpp"

namespace silvafit::stand {
namespace {

/// Larger numbers are not those of visits; they may be years without their century.
constexpr double kMostVisits = 50.0;

struct SeenTree {
  std::string_view tree{};
  double x = data::kMissing;
  double y = data::kMissing;
  bool is_alive = true;
};

/// The trees of one plot at one time.
struct TimeOfPlot {
  std::string_view text{};
  double years = data::kMissing;  ///< missing: the time has no order
  bool is_year = false;           ///< without a day
  std::vector<SeenTree> trees{};
  std::vector<std::size_t> rows{};
};

/// Sets the place of a time among others: its year or date, or the number of the visit.
void read_time(TimeOfPlot& time, DayPlace place) {
  double number = 0.0;
  if (const auto years = years_of(with_year_first(time.text, place))) {
    time.years = *years;
  } else if (data::parse_number(time.text, number) && number < kMostVisits) {
    time.years = number;
  } else if (const std::size_t slash = time.text.rfind('/'); slash != std::string_view::npos) {
    // The year of a day that does not exist.
    const auto year = years_of(time.text.substr(slash + 1));
    if (year) time.years = *year;
  }
  time.is_year = time.years == std::floor(time.years);
}

double years_between(const TimeOfPlot& earlier, const TimeOfPlot& later) {
  if (earlier.is_year == later.is_year) return later.years - earlier.years;
  return std::floor(later.years) - std::floor(earlier.years);
}

/// The trees of a visit, by their numbers.
class Visit {
 public:
  std::size_t without_row_in(const Visit& other) const {
    const auto is_unseen = [&other](const auto& tree) {
      const bool was_alive = std::ranges::any_of(tree.second, &SeenTree::is_alive);
      return was_alive && !other.trees_.contains(tree.first);
    };
    return static_cast<std::size_t>(std::ranges::count_if(trees_, is_unseen));
  }
  void add(const TimeOfPlot& time) {
    for (const SeenTree& tree : time.trees) trees_[tree.tree].push_back(tree);
  }
  bool has_tree_of(const TimeOfPlot& time) const {
    return std::ranges::any_of(time.trees, [this](const SeenTree& tree) {
      const auto same = trees_.find(tree.tree);
      return same != trees_.end() && std::ranges::any_of(same->second, [&](const SeenTree& one) {
               const double distance_m = std::hypot(one.x - tree.x, one.y - tree.y);
               return std::isnan(distance_m) || distance_m <= kResurveyMeters;
             });
    });
  }

 private:
  std::unordered_map<std::string_view, std::vector<SeenTree>> trees_{};
};

/// The visits of a plot by the order of times.
struct LastVisit {
  std::size_t begin = 0;  ///< its first time
  bool is_mixed = false;  ///< it may be several visits: no tree comes again
  bool is_long = false;   ///< the same, over more years than a campaign takes
  std::size_t unseen = 0;
};

/// The times from one on that follow each other too soon for a visit of their own. A time without
/// order is one of its own.
std::size_t end_of_campaign(const std::vector<TimeOfPlot>& times, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < times.size() && years_between(times[end - 1], times[end]) <= kBetweenVisits) ++end;
  return end;
}

/// \throws InputError as later_visits()
LastVisit last_visit(std::vector<TimeOfPlot>& times, const Place& place) {
  std::ranges::stable_sort(times, {}, [](const TimeOfPlot& time) {
    return std::isnan(time.years) ? std::numeric_limits<double>::infinity() : time.years;
  });
  LastVisit last;
  Visit before;
  Visit visit;
  for (std::size_t begin = 0, end = 0; begin < times.size(); begin = end) {
    end = end_of_campaign(times, begin);
    const bool has_order = !std::isnan(times[begin].years);
    const std::span<const TimeOfPlot> campaign(&times[begin], end - begin);
    const bool is_later = begin > 0 && std::ranges::any_of(campaign, [&](const TimeOfPlot& time) {
                            return visit.has_tree_of(time);
                          });
    last.is_mixed = !is_later && (last.is_mixed || begin > 0);
    if (is_later) {
      if (!has_order) {
        throw InputError(
            fmt::format("trees of {} were measured again at {}, which is neither a year or date "
                        "(2019, 2019-06-30 or 30.06.2019) nor the number of a visit; choose the "
                        "rows of one visit with `where`",
                        times[begin - 1].text,
                        times[begin].text),
            place);
      }
      last.begin = begin;
      before = std::exchange(visit, {});
    }
    last.is_long =
        last.is_mixed && years_between(times[last.begin], campaign.back()) > kLongestCampaign;
    for (const TimeOfPlot& time : campaign) visit.add(time);
  }
  last.unseen = before.without_row_in(visit);
  return last;
}

/// The plots that have rows of several times.
class PlotsAtTimes {
 public:
  PlotsAtTimes(const Inventory& inventory,
               const data::TextColumn& times,
               const TimedTrees& skipped);
  std::map<std::uint32_t, std::vector<TimeOfPlot>>& several() { return plots_; }
  /// The plots whose only time is more than a campaign before another one.
  std::vector<std::uint32_t> once_before(const TimeOfPlot& other) const;

 private:
  void find_several(std::uint32_t plot, std::string_view time);
  TimeOfPlot* time_of(std::uint32_t plot, std::string_view text);

  DayPlace day_place_ = DayPlace::kUnknown;
  std::vector<std::string_view> first_time_;  ///< by plot
  std::vector<char> has_several_;
  std::map<std::uint32_t, std::vector<TimeOfPlot>> plots_{};
};

PlotsAtTimes::PlotsAtTimes(const Inventory& inventory,
                           const data::TextColumn& times,
                           const TimedTrees& skipped)
    : first_time_(inventory.plot.levels().size()), has_several_(first_time_.size(), 0) {
  std::vector<std::string> texts(times.levels().begin(), times.levels().end());
  texts.insert(texts.end(), skipped.time.levels().begin(), skipped.time.levels().end());
  day_place_ = day_place(texts);
  const auto for_each = [&](const auto& use, const auto& use_skipped) {
    for (std::size_t row = 0; row < times.size(); ++row) {
      if (!times.is_missing(row) && !inventory.plot.is_missing(row)) use(row);
    }
    for (std::size_t i = 0; i < skipped.time.size(); ++i) {
      const std::uint32_t plot = inventory.plot.code_of(skipped.plot[i]);
      if (plot != data::TextColumn::kMissingCode && !skipped.time.is_missing(i))
        use_skipped(i, plot);
    }
  };
  for_each([&](std::size_t row) { find_several(inventory.plot.code(row), times[row]); },
           [&](std::size_t i, std::uint32_t plot) { find_several(plot, skipped.time[i]); });
  for_each(
      [&](std::size_t row) {
        TimeOfPlot* const time = time_of(inventory.plot.code(row), times[row]);
        if (time == nullptr) return;
        SeenTree tree{.tree = inventory.tree[row]};
        if (inventory.has_coordinates()) tree.x = inventory.x[row];
        if (inventory.has_coordinates()) tree.y = inventory.y[row];
        time->trees.push_back(tree);
        time->rows.push_back(row);
      },
      [&](std::size_t i, std::uint32_t plot) {
        TimeOfPlot* const time = time_of(plot, skipped.time[i]);
        if (time != nullptr) time->trees.push_back({.tree = skipped.tree[i], .is_alive = false});
      });
}

std::vector<std::uint32_t> PlotsAtTimes::once_before(const TimeOfPlot& other) const {
  std::vector<std::uint32_t> plots;
  for (std::uint32_t plot = 0; plot < first_time_.size(); ++plot) {
    if (has_several_[plot] != 0 || first_time_[plot].empty()) continue;
    TimeOfPlot time{.text = first_time_[plot]};
    read_time(time, day_place_);
    if (years_between(time, other) > kLongestCampaign) plots.push_back(plot);
  }
  return plots;
}

void PlotsAtTimes::find_several(std::uint32_t plot, std::string_view time) {
  if (first_time_[plot].empty()) first_time_[plot] = time;
  if (first_time_[plot] != time) has_several_[plot] = 1;
}

/// None if the plot has one time.
TimeOfPlot* PlotsAtTimes::time_of(std::uint32_t plot, std::string_view text) {
  if (has_several_[plot] == 0) return nullptr;
  std::vector<TimeOfPlot>& times = plots_[plot];
  const auto known = std::ranges::find(times, text, &TimeOfPlot::text);
  if (known != times.end()) return &*known;
  times.push_back({.text = text});
  read_time(times.back(), day_place_);
  return &times.back();
}

}  // namespace

void VisitCounts::add(const VisitCounts& other) {
  if (plots == 0) first = other.first;
  if (mixed == 0 || (other.is_long && !is_long)) first_mixed = other.first_mixed;
  is_long = is_long || other.is_long;
  plots += other.plots;
  rows += other.rows;
  unseen += other.unseen;
  mixed += other.mixed;
  if (older == 0) first_older = other.first_older;
  older += other.older;
}

std::vector<std::string> VisitCounts::notes() const {
  std::vector<std::string> notes;
  if (plots > 0) {
    notes.push_back(fmt::format(
        "{} measured several times: the last visit is used ({}), {} of earlier ones {} skipped{}; "
        "`where` chooses another time, study with a `period` models the rows of all times, and "
        "stand with `growth` compares them",
        counted(plots, "plot was", "plots were"),
        first,
        counted(rows, "row", "rows"),
        rows == 1 ? "is" : "are",
        unseen == 0 ? ""
                    : fmt::format(", and {} gone",
                                  counted(unseen,
                                          "tree of the visit before it that has no row of it is",
                                          "trees of the visit before it that have no row of it "
                                          "are"))));
  }
  if (older > 0) {
    notes.push_back(fmt::format(
        "{} measured only before the last visits of these ({}) and {} as of the same time; `where` "
        "leaves plots out",
        counted(older, "plot was", "plots were"),
        first_older,
        older == 1 ? "counts" : "count"));
  }
  if (mixed > 0) {
    notes.push_back(
        fmt::format("{} rows of several times, but no tree comes again ({}): all are used as of "
                    "one visit; if they are of several, choose one with `where`",
                    counted(mixed, "plot has", "plots have"),
                    first_mixed));
  }
  return notes;
}

std::vector<std::string> later_visits(const Inventory& inventory,
                                      const data::TextColumn& times,
                                      const TimedTrees& skipped,
                                      VisitCounts& counts) {
  std::vector<std::string> later(inventory.size());
  if (times.size() == 0) return later;
  PlotsAtTimes plots(inventory, times, skipped);
  TimeOfPlot first_last{.years = std::numeric_limits<double>::infinity()};
  for (auto& [plot, of_plot] : plots.several()) {
    const Place place{.file = inventory.file, .plot = std::string(inventory.plot.levels()[plot])};
    const auto [begin, is_mixed, is_long, unseen] = last_visit(of_plot, place);
    VisitCounts found;
    for (std::size_t i = 0; i < begin; ++i) {
      found.rows += of_plot[i].rows.size();
      for (const std::size_t row : of_plot[i].rows) later[row] = of_plot.back().text;
    }
    if (begin > 0) {
      found.plots = 1;
      found.unseen = unseen;
      found.first = fmt::format("plot {}: {}", place.plot, of_plot.back().text);
      if (of_plot[begin].years < first_last.years) {
        first_last = {.years = of_plot[begin].years, .is_year = of_plot[begin].is_year};
      }
    }
    if (is_mixed) {
      found.mixed = 1;
      found.is_long = is_long;
      found.first_mixed =
          fmt::format("plot {}: {} and {}", place.plot, of_plot[begin].text, of_plot.back().text);
    }
    counts.add(found);
  }
  if (!std::isfinite(first_last.years)) return later;
  const std::vector<std::uint32_t> once = plots.once_before(first_last);
  if (once.empty()) return later;
  counts.add({.older = once.size(),
              .first_older = fmt::format("plot {}", inventory.plot.levels()[once.front()])});
  return later;
}

}  // namespace silvafit::stand
