// SPDX-License-Identifier: MIT
#include "silvafit/study/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "simulation/simulated_response.hpp"
#include "simulation/simulated_stems.hpp"

namespace silvafit::study {
namespace {

constexpr double kLowestHeight = 2.0;
constexpr double kLowestCrownBase = 0.15;
constexpr double kHighestCrownBase = 0.95;  ///< of height
constexpr double kSmallestCrown = 0.4;

/// Numbers of the random streams of the responses.
enum Response : std::size_t { kHeight = 0, kCrownBase = 1, kCrownWidth = 2 };

/// The trees of one species: their rows in the inventory and their data columns.
struct Group {
  const SpeciesDesign* design = nullptr;
  std::size_t index = 0;
  std::vector<std::size_t> rows{};
  std::vector<std::size_t> plot_of_tree{};
  Columns columns{};
};

/// Collects a variable of all trees into a column of each species.
void spread_over_groups(std::vector<Group>& groups,
                        const std::string& name,
                        const std::vector<double>& values) {
  for (Group& group : groups) {
    std::vector<double>& column = group.columns[name];
    column.clear();
    for (const std::size_t row : group.rows) column.push_back(values[row]);
  }
}

stand::Inventory empty_trees(const SimulationDesign& design, const std::vector<Stem>& stems) {
  stand::Inventory inventory;
  for (std::size_t row = 0; row < stems.size(); ++row) {
    inventory.plot.append(design.plots[stems[row].plot].id);
    inventory.tree.append(fmt::format("{}", row + 1));
    inventory.species.append(design.species[stems[row].species].code);
    inventory.x.push_back(stems[row].x);
    inventory.y.push_back(stems[row].y);
  }
  inventory.cw_m.assign(stems.size(), 1.0);
  return inventory;
}

std::vector<Group> groups_of(const SimulationDesign& design, const std::vector<Stem>& stems) {
  std::vector<Group> groups(design.species.size());
  for (std::size_t s = 0; s < groups.size(); ++s) {
    groups[s].design = &design.species[s];
    groups[s].index = s;
  }
  for (std::size_t row = 0; row < stems.size(); ++row) {
    groups[stems[row].species].rows.push_back(row);
    groups[stems[row].species].plot_of_tree.push_back(stems[row].plot);
  }
  return groups;
}

void check_enough_trees(const SimulationDesign& design, const std::vector<Stem>& stems) {
  std::vector<std::size_t> trees(design.plots.size(), 0);
  for (const Stem& stem : stems) ++trees[stem.plot];
  const bool by_plot = design.scope == stand::SearchScope::kPlot;
  for (std::size_t plot = 0; plot < trees.size(); ++plot) {
    const std::size_t count = by_plot ? trees[plot] : stems.size();
    if (count > design.neighbors) continue;
    throw InputError(fmt::format("{} has {} trees; at least {} neighbors per tree are needed",
                                 by_plot ? "plot " + design.plots[plot].id : "the stand",
                                 count,
                                 design.neighbors),
                     {.column = "neighbors.count"});
  }
}

stand::StructuralUnits units_of(const SimulationDesign& design,
                                const stand::Inventory& inventory,
                                unsigned threads) {
  return stand::structural_units(inventory,
                                 {.neighbors = design.neighbors,
                                  .edge = stand::EdgeCorrection::kNone,
                                  .scope = design.scope,
                                  .threads = threads});
}

/// Random numbers of a crown, which are drawn once and do not depend on C.
struct CrownDraw {
  double residual = 0.0;                                   ///< standard normal
  std::array<double, 4> radius_share{1.0, 1.0, 1.0, 1.0};  ///< of the mean radius: e, w, s, n
};

CrownDraw draw_crown(double asymmetry, Random& residuals, Random& shapes) {
  constexpr double kSmallestShare = 0.3;
  CrownDraw crown{.residual = residuals.normal()};
  double sum = 0.0;
  for (double& share : crown.radius_share) {
    share = std::max(kSmallestShare, shapes.normal(1.0, asymmetry));
    sum += share;
  }
  for (double& share : crown.radius_share) share *= 4.0 / sum;
  return crown;
}

/// The crowns of one species.
class Crowns {
 public:
  Crowns(const Group& group, const SimulationDesign& design, std::uint64_t seed)
      : group_(&group), response_(response_of(group, design, seed)) {
    Random residuals(seed, stream_of(Draw::kResiduals, group.index, kCrownWidth));
    Random shapes(seed, stream_of(Draw::kShape, group.index));
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      draws_.push_back(draw_crown(design.crown_asymmetry, residuals, shapes));
    }
    const std::vector<double> means = response_.means(group.columns);
    sigma_ = response_.sigma(response_.relative_spread(means, group.columns));
  }

  /// Sets crown widths and radii for the C in the group's columns.
  void measure(stand::Inventory& inventory) {
    const std::vector<double> means = response_.means(group_->columns);
    const std::vector<double> spread = response_.relative_spread(means, group_->columns);
    clamped_ = 0;
    for (std::size_t i = 0; i < means.size(); ++i) {
      double width = means[i] + sigma_ * spread[i] * draws_[i].residual;
      if (!(width >= kSmallestCrown)) {
        width = kSmallestCrown;
        ++clamped_;
      }
      measure_tree(group_->rows[i], width, draws_[i], inventory);
    }
  }

  DrawnResponse drawn() const {
    return {.sigma = sigma_, .random_effects = response_.random_effects(), .clamped = clamped_};
  }

 private:
  static SimulatedResponse response_of(const Group& group,
                                       const SimulationDesign& design,
                                       std::uint64_t seed) {
    Random effects(seed, stream_of(Draw::kEffects, group.index, kCrownWidth));
    return {group.design->cw, design.plots.size(), group.plot_of_tree, effects};
  }

  /// Rounds radii to whole centimeters and computes the crown width from them.
  static void measure_tree(std::size_t row,
                           double width,
                           const CrownDraw& draw,
                           stand::Inventory& inventory) {
    std::vector<double>* const radii[] = {
        &inventory.cr_e_m, &inventory.cr_w_m, &inventory.cr_s_m, &inventory.cr_n_m};
    double sum_cm = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const double radius_cm = std::max(1.0, std::round(50.0 * width * draw.radius_share[k]));
      (*radii[k])[row] = radius_cm / 100.0;
      sum_cm += radius_cm;
    }
    inventory.cw_m[row] = sum_cm / 200.0;
  }

  const Group* group_;
  SimulatedResponse response_;
  std::vector<CrownDraw> draws_;
  double sigma_ = 0.0;
  std::size_t clamped_ = 0;
};

/// Updates C of the trees and returns the number of changed values.
///
/// All trees change together at first. Two trees that depend on each other might then alternate
/// without end, so later each changes with probability 1/2.
std::size_t adopt(std::vector<double>& crowding,
                  const std::vector<double>& updated,
                  bool hesitantly,
                  Random& random) {
  std::size_t changed = 0;
  for (std::size_t row = 0; row < crowding.size(); ++row) {
    if (crowding[row] == updated[row]) continue;
    ++changed;
    if (!hesitantly || random.uniform() < 0.5) crowding[row] = updated[row];
  }
  return changed;
}

/// Iterates crown widths and C, which depend on each other, until they agree. Residuals are fixed.
void settle_crowns(const SimulationDesign& design,
                   std::uint64_t seed,
                   unsigned threads,
                   std::vector<Group>& groups,
                   SimulatedStand& result) {
  constexpr std::size_t kPassesTogether = 20;
  constexpr std::size_t kMostPasses = 200;
  constexpr double kFirstCrowding = 0.5;
  stand::Inventory& inventory = result.inventory;
  for (auto* radii : {&inventory.cr_e_m, &inventory.cr_w_m, &inventory.cr_s_m, &inventory.cr_n_m}) {
    radii->resize(inventory.size());
  }
  std::vector<double> crowding(inventory.size(), kFirstCrowding);
  spread_over_groups(groups, "C", crowding);
  std::vector<Crowns> crowns;
  crowns.reserve(groups.size());
  for (const Group& group : groups) crowns.emplace_back(group, design, seed);

  Random random(seed, stream_of(Draw::kCrowding));
  do {
    for (Crowns& species : crowns) species.measure(inventory);
    const stand::StructuralUnits units = units_of(design, inventory, threads);
    const bool hesitantly = ++result.crowding_passes > kPassesTogether;
    if (result.crowding_passes == kMostPasses) {
      // C in the file is computed from its crowns, also for trees that did not converge.
      result.crowding_unsettled = adopt(crowding, units.C, false, random);
      spread_over_groups(groups, "C", crowding);
      break;
    }
    result.crowding_unsettled = adopt(crowding, units.C, hesitantly, random);
    spread_over_groups(groups, "C", crowding);
  } while (result.crowding_unsettled > 0);
  for (std::size_t s = 0; s < crowns.size(); ++s) result.species[s].cw = crowns[s].drawn();
}

/// A response with residuals between limits: redrawn while outside, finally set to the limit.
template <typename Limits>
std::vector<double> draw_between(const Group& group,
                                 const ResponseDesign& response_design,
                                 Response response_number,
                                 std::size_t plots,
                                 std::uint64_t seed,
                                 const Limits& limits,
                                 DrawnResponse& drawn) {
  constexpr int kAttempts = 100;
  Random effects(seed, stream_of(Draw::kEffects, group.index, response_number));
  Random residuals(seed, stream_of(Draw::kResiduals, group.index, response_number));
  const SimulatedResponse response(response_design, plots, group.plot_of_tree, effects);
  const std::vector<double> means = response.means(group.columns);
  const std::vector<double> spread = response.relative_spread(means, group.columns);
  drawn.sigma = response.sigma(spread);
  drawn.random_effects = response.random_effects();
  std::vector<double> result;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const auto [low, high] = limits(i);
    double value = 0.0;
    int attempt = 0;
    do {
      value = means[i] + drawn.sigma * spread[i] * residuals.normal();
    } while (!(value >= low && value <= high) && ++attempt < kAttempts);
    if (attempt > 0) ++drawn.redrawn;
    if (attempt == kAttempts) ++drawn.clamped;
    result.push_back(rounded(std::clamp(value, low, high), 10.0));
  }
  return result;
}

void draw_heights(const SimulationDesign& design,
                  std::uint64_t seed,
                  Group& group,
                  SimulatedStand& result) {
  DrawnSpecies& drawn = result.species[group.index];
  const auto height_limits = [](std::size_t) {
    return std::pair(kLowestHeight, std::numeric_limits<double>::max());
  };
  group.columns["h"] = draw_between(
      group, group.design->h, kHeight, design.plots.size(), seed, height_limits, drawn.h);
  const std::vector<double>& heights = group.columns["h"];
  const auto base_limits = [&](std::size_t i) {
    return std::pair(kLowestCrownBase, kHighestCrownBase * heights[i]);
  };
  const std::vector<double> bases = draw_between(
      group, group.design->hcb, kCrownBase, design.plots.size(), seed, base_limits, drawn.hcb);
  for (std::size_t i = 0; i < group.rows.size(); ++i) {
    result.inventory.h_m[group.rows[i]] = heights[i];
    result.inventory.hcb_m[group.rows[i]] = bases[i];
  }
}

}  // namespace

SimulatedStand simulate(const SimulationDesign& design, std::uint64_t seed, unsigned threads) {
  const std::vector<Stem> stems = place_stems(design, seed);
  check_enough_trees(design, stems);
  SimulatedStand result;
  result.inventory = empty_trees(design, stems);
  result.species.resize(design.species.size());
  std::vector<std::vector<double>> plot_factors;
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    plot_factors.push_back(draw_plot_factors(design, s, seed));
    result.species[s].dbh_plot_factor = plot_factors[s];
  }
  result.inventory.dbh_cm = draw_dbh(design, stems, plot_factors, seed);
  result.inventory.z = draw_elevation(design, stems, seed);
  result.inventory.h_m.resize(stems.size());
  result.inventory.hcb_m.resize(stems.size());

  std::vector<Group> groups = groups_of(design, stems);
  const stand::StructuralUnits units = units_of(design, result.inventory, threads);
  spread_over_groups(groups, "W", units.W);
  spread_over_groups(groups, "M", units.M);
  spread_over_groups(groups, "U", units.U);
  spread_over_groups(groups, "dbh", result.inventory.dbh_cm);
  spread_over_groups(groups, "z", result.inventory.z);
  settle_crowns(design, seed, threads, groups, result);
  for (Group& group : groups) {
    result.species[group.index].trees = group.rows.size();
    draw_heights(design, seed, group, result);
  }
  return result;
}

std::vector<std::string> notes_on_limits(const SimulationDesign& design,
                                         const SimulatedStand& stand) {
  constexpr double kLargeShare = 0.1;
  std::vector<std::string> notes;
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    const DrawnSpecies& species = stand.species[s];
    const auto note = [&](std::string_view name, const DrawnResponse& drawn) {
      const std::size_t met = std::max(drawn.redrawn, drawn.clamped);
      if (static_cast<double>(met) <= kLargeShare * static_cast<double>(species.trees)) return;
      notes.push_back(
          fmt::format("{} of {}: {} of {} trees reached a limit ({} were set to it), so the file "
                      "does not follow the design; check the formula, its coefficients and sigma",
                      name,
                      design.species[s].code,
                      met,
                      species.trees,
                      drawn.clamped));
    };
    note("h", species.h);
    note("hcb", species.hcb);
    note("cw", species.cw);
  }
  return notes;
}

}  // namespace silvafit::study
