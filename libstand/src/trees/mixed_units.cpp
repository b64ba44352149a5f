// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "silvafit/base/median.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/stand/size_units.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kFewestJudged = 3;
// No known stand is outside of these limits, pollards and thickets of saplings included.
constexpr double kImpossiblyStout = 12.0;
constexpr double kImpossiblySlender = 350.0;

/// A unit that a plot may be in.
struct Hypothesis {
  std::string_view dbh_unit{};
  double dbh_factor = 1.0;  ///< to cm
  std::string_view h_unit{};
  double h_factor = 1.0;   ///< to m
  double contrast = 1.0;   ///< smallest ratio to the expected heights without it
  double tolerance = 1.0;  ///< largest ratio to the expected heights with it
  /// Plots of at least this median h/dbh and h, as written, are tested.
  double lowest_slenderness = 0.0;
  double lowest_h = 0.0;
  double lowest_excess = 0.0;  ///< smallest h/dbh relative to that of the usual plots
};
// Inches and feet are near to our units. Thickets of small trees have such ratios, too, so that
// plots must be tall and fit well.
constexpr std::array<Hypothesis, 6> kHypotheses{{{"mm", 0.1, "", 1.0, 3.0, 1.6, 0.0, 0.0},
                                                 {"in", 2.54, "", 1.0, 1.4, 1.2, 150.0, 10.0, 2.1},
                                                 {"", 1.0, "ft", 0.3048, 2.0, 1.3, 150.0, 15.0},
                                                 {"in", 2.54, "ft", 0.3048, 2.5, 1.35, 150.0, 15.0},
                                                 {"", 1.0, "dm", 0.1, 3.0, 1.6, 0.0, 0.0},
                                                 {"", 1.0, "cm", 0.01, 3.0, 1.6, 0.0, 0.0}}};
// Thickets are below both limits; short trees in other units exceed them.
constexpr double kSlenderThickets = 200.0;
constexpr double kTallThickets = 1.9;
// The larger the deviation from the expected heights without a unit, the larger it may be with it,
// because sites differ: half of it in logarithms, but not more than this.
constexpr double kNearer = 0.5;
constexpr double kWidestTolerance = 1.6;
// Smaller deviations, in standard deviations of the other plots, are explained by another site:
// the 1 % quantile of a normal distribution.
constexpr double kOtherSite = 2.33;

struct SizedTree {
  double dbh_cm = 0.0;
  double h_m = 0.0;
  std::uint32_t species = 0;
};

double slenderness(const SizedTree& tree) { return 100.0 * tree.h_m / tree.dbh_cm; }

double median_ratio(const std::vector<SizedTree>& trees) {
  std::vector<double> values;
  values.reserve(trees.size());
  for (const SizedTree& tree : trees) values.push_back(slenderness(tree));
  return median(std::move(values));
}

/// Heights of trees by species and dbh.
class Heights {
 public:
  void add(const SizedTree& tree) { trees_[tree.species].push_back({tree.dbh_cm, tree.h_m}); }
  void sort() {
    for (auto& [species, trees] : trees_) std::ranges::sort(trees);
  }
  /// The height at a dbh by the trees of similar dbh; none if there are few.
  std::optional<double> at(std::uint32_t species, double dbh_cm) const;

 private:
  std::map<std::uint32_t, std::vector<std::pair<double, double>>> trees_{};
};

std::optional<double> Heights::at(std::uint32_t species, double dbh_cm) const {
  constexpr double kWidth = 1.6;
  constexpr std::ptrdiff_t kFewest = 3;
  constexpr std::ptrdiff_t kMost = 400;
  // Heights grow with a power of dbh; of a wide range of curves it is near this one.
  constexpr double kPower = 0.6;
  const auto found = trees_.find(species);
  if (found == trees_.end()) return std::nullopt;
  const auto& trees = found->second;
  auto first = std::ranges::lower_bound(trees, std::pair(dbh_cm / kWidth, 0.0));
  auto last = std::ranges::lower_bound(trees, std::pair(dbh_cm * kWidth, 0.0));
  if (last - first < kFewest) return std::nullopt;
  const std::ptrdiff_t step = std::max<std::ptrdiff_t>(1, (last - first) / kMost);
  std::vector<double> heights;
  for (; last - first >= step; first += step) {
    heights.push_back(first->second * std::pow(dbh_cm / first->first, kPower));
  }
  return median(std::move(heights));
}

class Finder {
 public:
  explicit Finder(const TreeSizes& trees);
  std::vector<MixedUnits> run();

 private:
  bool is_usual(std::size_t plot) const {
    return slenderness_[plot] >= kLowestUsualSlenderness &&
           slenderness_[plot] <= kHighestUsualSlenderness;
  }
  /// Ratio of the heights of a plot, read in this unit, to those expected from the other plots.
  std::optional<double> height_ratio(std::size_t plot, const Hypothesis& unit) const;
  const Hypothesis* unit_of(std::size_t plot) const;
  double median_h(std::size_t plot) const;
  double miss(std::size_t plot) const;
  double least_contrast(std::size_t plot, const Hypothesis& unit) const;
  double spread_of_sites() const;

  std::vector<std::vector<SizedTree>> trees_{};  ///< by plot
  std::vector<std::string> plots_{};
  std::vector<double> slenderness_{};  ///< medians, NaN where a plot has too few trees
  double usual_slenderness_ = 0.0;
  Heights usual_{};
};

Finder::Finder(const TreeSizes& trees)
    : trees_(trees.plot.levels().size()), plots_(trees.plot.levels()) {
  for (std::size_t i = 0; i < trees.plot.size(); ++i) {
    const bool is_known = trees.dbh_cm[i] > 0.0 && trees.h_m[i] > 0.0;
    if (!is_known || trees.plot.is_missing(i)) continue;
    trees_[trees.plot.code(i)].push_back(
        {.dbh_cm = trees.dbh_cm[i],
         .h_m = trees.h_m[i],
         .species = trees.species == nullptr ? 0 : trees.species->code(i)});
  }
  for (const std::vector<SizedTree>& plot : trees_) {
    slenderness_.push_back(plot.size() < kFewestJudged ? data::kMissing : median_ratio(plot));
  }
}

std::optional<double> Finder::height_ratio(std::size_t plot, const Hypothesis& unit) const {
  std::vector<double> ratios;
  for (const SizedTree& tree : trees_[plot]) {
    const auto usual = usual_.at(tree.species, tree.dbh_cm * unit.dbh_factor);
    if (usual) ratios.push_back(tree.h_m * unit.h_factor / *usual);
  }
  if (ratios.size() < kFewestJudged || 2 * ratios.size() < trees_[plot].size()) return std::nullopt;
  return median(std::move(ratios));
}

/// Ratio by which the heights of a plot as written are too high or too low; if no other plot can be
/// compared, infinite if no real stand has this h/dbh, and otherwise 1.
double Finder::miss(std::size_t plot) const {
  const std::optional<double> ratio = height_ratio(plot, {});
  if (ratio) return std::max(*ratio, 1.0 / *ratio);
  const double slenderness = slenderness_[plot];
  const bool is_possible = slenderness >= kImpossiblyStout && slenderness <= kImpossiblySlender;
  return is_possible ? 1.0 : std::numeric_limits<double>::infinity();
}

/// The smallest ratio to the expected heights for which another unit is assumed.
double Finder::least_contrast(std::size_t plot, const Hypothesis& unit) const {
  const bool is_tall = median_h(plot) >= unit.lowest_h;
  if (is_tall && slenderness_[plot] >= unit.lowest_slenderness) return unit.contrast;
  if (slenderness_[plot] >= kSlenderThickets) return std::max(unit.contrast, kTallThickets);
  return std::numeric_limits<double>::infinity();
}

double Finder::median_h(std::size_t plot) const {
  std::vector<double> heights;
  for (const SizedTree& tree : trees_[plot]) heights.push_back(tree.h_m);
  return median(std::move(heights));
}

/// The standard deviation, from the median deviation, of the logarithmic deviations of usual plots
/// from the expected heights.
double Finder::spread_of_sites() const {
  constexpr std::size_t kEnough = 200;  // plots
  constexpr double kOfMedian = 1.4826;
  std::vector<std::size_t> usual;
  for (std::size_t plot = 0; plot < plots_.size(); ++plot) {
    if (is_usual(plot)) usual.push_back(plot);
  }
  std::vector<double> deviations;
  for (std::size_t i = 0; i < usual.size(); i += 1 + usual.size() / kEnough) {
    deviations.push_back(std::log(miss(usual[i])));
  }
  return deviations.empty() ? 0.0 : kOfMedian * median(std::move(deviations));
}

/// The unit that explains the sizes of a plot best; null if none does.
const Hypothesis* Finder::unit_of(std::size_t plot) const {
  const double without = miss(plot);
  const Hypothesis* best = nullptr;
  double smallest = 0.0;
  for (const Hypothesis& unit : kHypotheses) {
    const double slenderness = slenderness_[plot] * unit.h_factor / unit.dbh_factor;
    if (slenderness < kLowestUsualSlenderness || slenderness > 2.0 * kHighestUsualSlenderness)
      continue;
    if (slenderness_[plot] < unit.lowest_excess * usual_slenderness_) continue;
    const std::optional<double> ratio = height_ratio(plot, unit);
    if (!ratio || !(without > least_contrast(plot, unit))) continue;
    const double tolerance =
        std::max(std::log(unit.tolerance),
                 std::min(std::log(kWidestTolerance), kNearer * std::log(without)));
    const double missed = std::abs(std::log(*ratio));
    if (missed > tolerance) continue;
    // Inches may be mistaken for feet by heights alone.
    const double deviation = missed + std::abs(std::log(slenderness / usual_slenderness_));
    if (best != nullptr && deviation >= smallest) continue;
    best = &unit;
    smallest = deviation;
  }
  return best;
}

std::vector<MixedUnits> Finder::run() {
  std::vector<double> usual;
  std::vector<std::size_t> unusual;
  for (std::size_t plot = 0; plot < plots_.size(); ++plot) {
    if (std::isnan(slenderness_[plot])) continue;
    is_usual(plot) ? usual.push_back(slenderness_[plot]) : unusual.push_back(plot);
  }
  if (usual.empty() || unusual.empty()) return {};
  usual_slenderness_ = median(std::move(usual));
  for (std::size_t plot = 0; plot < plots_.size(); ++plot) {
    if (!is_usual(plot)) continue;
    for (const SizedTree& tree : trees_[plot]) usual_.add(tree);
  }
  usual_.sort();
  std::map<const Hypothesis*, std::vector<std::size_t>> plots_of_unit;
  for (const std::size_t plot : unusual) {
    if (const Hypothesis* const unit = unit_of(plot)) plots_of_unit[unit].push_back(plot);
  }
  if (plots_of_unit.empty()) return {};
  const double least = kOtherSite * spread_of_sites();
  for (auto& [unit, plots] : plots_of_unit) {
    std::erase_if(plots, [&](std::size_t plot) { return std::log(miss(plot)) < least; });
  }
  std::erase_if(plots_of_unit, [](const auto& found) { return found.second.empty(); });
  std::vector<MixedUnits> mixed;
  for (const auto& [unit, plots] : plots_of_unit) {
    MixedUnits found{.dbh_unit = std::string(unit->dbh_unit),
                     .h_unit = std::string(unit->h_unit),
                     .slenderness_of_others = usual_slenderness_};
    std::vector<double> values;
    for (const std::size_t plot : plots) {
      found.plots.push_back(plots_[plot]);
      values.push_back(slenderness_[plot]);
    }
    found.slenderness = median(std::move(values));
    mixed.push_back(std::move(found));
  }
  return mixed;
}

/// "plot 7", "plots 1, 2 and 9 more".
std::string plots_text(const std::vector<std::string>& plots) {
  constexpr std::size_t kShown = 12;
  std::string text = plots.size() == 1 ? "plot " : "plots ";
  text += fmt::format(
      "{}", fmt::join(plots.begin(), plots.begin() + std::min(kShown, plots.size()), ", "));
  return plots.size() <= kShown ? text : fmt::format("{} and {} more", text, plots.size() - kShown);
}

std::string unit_text(const MixedUnits& mixed) {
  if (mixed.h_unit.empty()) return "dbh seems to be in " + mixed.dbh_unit;
  if (mixed.dbh_unit.empty()) return "h seems to be in " + mixed.h_unit;
  return fmt::format("dbh seems to be in {} and h in {}", mixed.dbh_unit, mixed.h_unit);
}

}  // namespace

std::vector<MixedUnits> find_mixed_units(const TreeSizes& trees) {
  if (trees.dbh_cm.empty() || trees.h_m.empty()) return {};
  return Finder(trees).run();
}

std::string describe_mixed_units(const std::vector<MixedUnits>& mixed) {
  if (mixed.empty()) return {};
  std::string text = "the file mixes units: ";
  for (const MixedUnits& one : mixed) {
    text += fmt::format("{}in {} {} (median h/dbh {:.0f}, in other plots {:.0f})",
                        &one == &mixed.front() ? "" : "; ",
                        plots_text(one.plots),
                        unit_text(one),
                        one.slenderness,
                        one.slenderness_of_others);
  }
  return text + "; correct the file; if the values are correct, use `trust_units=true`";
}

}  // namespace silvafit::stand
