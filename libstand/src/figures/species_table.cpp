// SPDX-License-Identifier: MIT
#include "silvafit/stand/species_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "figures/species_sums.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "trees/plot_order.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

/// Along one side of a window: the quadrat of a tree, from 0. A tree on a border belongs to the
/// next quadrat, with a tolerance for rounding, but on the window's own border to the last.
long long quadrat_of(double offset_m, double extent_m, double quadrat_m, double rounding_m) {
  constexpr double kRounding = 1e-9;
  const double rounding = std::max(kRounding, rounding_m / quadrat_m);
  const double quadrats = std::ceil(extent_m / quadrat_m - rounding);
  const double own = std::floor(offset_m / quadrat_m + rounding);
  constexpr double kMost = 1e15;  // more quadrats than this cannot be distinguished
  return static_cast<long long>(std::clamp(own, 0.0, std::clamp(quadrats - 1.0, 0.0, kMost)));
}

}  // namespace

double usual_quadrat_m(bool is_only_plot, const std::vector<SampledArea>& areas) {
  constexpr double kQuadratMeters = 10.0;
  const bool has_window = !areas.empty() && areas.front().window.has_value();
  return is_only_plot && has_window ? kQuadratMeters : 0.0;
}

std::string describe_frequency(double quadrat_m) {
  return quadrat_m > 0.0 ? fmt::format("Frequency is that in quadrats of {} m", quadrat_m)
                         : "Frequency is that in plots";
}

void CompositionSums::add(const std::vector<const SpeciesMember*>& members,
                          std::size_t species_count) {
  species_.resize(species_count);
  std::vector<std::pair<std::size_t, std::tuple<std::size_t, long long, long long>>> occurrences;
  for (const SpeciesMember* member : members) {
    species_[member->species].relative_density += member->represented;
    stems_ += member->represented;
    species_[member->species].relative_dominance += member->basal_area_m2;
    basal_m2_ += member->basal_area_m2;
    occurrences.emplace_back(member->species, member->quadrat);
  }
  std::ranges::sort(occurrences);
  occurrences.erase(std::unique(occurrences.begin(), occurrences.end()), occurrences.end());
  // The number of quadrats cancels: only the number of quadrats with each species matters.
  for (const auto& [species, quadrat] : occurrences) species_[species].relative_frequency += 1.0;
  occurrences_ += static_cast<double>(occurrences.size());
}

std::vector<Importance> CompositionSums::importance() const {
  std::vector<Importance> result = species_;
  if (stems_ == 0.0) return result;
  for (Importance& importance : result) {
    importance.relative_density *= 100.0 / stems_;
    importance.relative_frequency *= 100.0 / occurrences_;
    importance.relative_dominance *= 100.0 / basal_m2_;
    importance.value = (importance.relative_density + importance.relative_frequency +
                        importance.relative_dominance) /
                       3.0;
  }
  return result;
}

void LayerSums::add(const std::vector<std::vector<const SpeciesMember*>>& plots,
                    const std::vector<const SpeciesMember*>& members,
                    std::size_t species_count) {
  all_.add(members, species_count);
  if (over_plots_.size() < species_count) {
    // A species that comes for the first time has the importance 0 in all plots before.
    Moments of_zeros;
    for (std::size_t plot = 0; plot < plots_; ++plot) of_zeros.add(0.0);
    over_plots_.resize(species_count, of_zeros);
  }
  for (const auto& plot : plots) {
    // A plot without trees in this layer has no composition and is skipped.
    if (plot.empty()) continue;
    CompositionSums own;
    own.add(plot, species_count);
    const std::vector<Importance> importance = own.importance();
    for (std::size_t i = 0; i < species_count; ++i) over_plots_[i].add(importance[i].value);
    ++plots_;
  }
}

std::vector<Importance> LayerSums::importance() const {
  std::vector<Importance> result = all_.importance();
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i].plot_mean = over_plots_[i].mean();
    result[i].plot_sd = over_plots_[i].standard_deviation();
  }
  return result;
}

void SpeciesSums::check(const std::vector<SampledArea>& areas) const {
  const std::vector<double>& bounds = options_.layers.bounds_m;
  const bool is_ascending =
      std::ranges::adjacent_find(bounds, std::greater_equal{}) == bounds.end() &&
      std::ranges::all_of(bounds, [](double bound) { return bound > 0.0 && std::isfinite(bound); });
  if (!is_ascending) {
    throw UsageError("layer limits must be above 0 m and increasing", {.column = "`layers`"});
  }
  if (!(options_.dominant_trees_per_ha > 0.0) || std::isinf(options_.dominant_trees_per_ha)) {
    throw UsageError(fmt::format("{} trees per ha must be above 0", options_.dominant_trees_per_ha),
                     {.column = "`dominant_trees`"});
  }
  if (!(options_.quadrat_m >= 0.0) || std::isinf(options_.quadrat_m)) {
    throw UsageError(fmt::format("{} m must be 0 or more", options_.quadrat_m),
                     {.column = "`quadrat`"});
  }
  const bool has_windows =
      std::ranges::all_of(areas, [](const SampledArea& area) { return area.window.has_value(); });
  if (options_.quadrat_m > 0.0 && !has_windows) {
    throw UsageError(
        "quadrats need windows, not `plot_area`: give `window` or `circle` instead, or omit "
        "`quadrat` to use the plots as quadrats",
        {.column = "`quadrat`"});
  }
}

void SpeciesSums::find_species(const Inventory& inventory) {
  number_of_code_.clear();
  for (const std::string& name : inventory.species.levels()) {
    const auto [entry, is_new] = numbers_.try_emplace(name, species_.size());
    if (is_new) species_.push_back({.name = name});
    number_of_code_.push_back(entry->second);
  }
  if (inventory.lines.empty()) return;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    Species& own = species_[number_of(inventory, tree)];
    own.first_line = std::min(own.first_line, inventory.lines[tree]);
  }
}

std::vector<SpeciesMember> SpeciesSums::members_of(const Inventory& inventory,
                                                   const std::vector<SampledArea>& areas) const {
  std::vector<SpeciesMember> members;
  for (std::size_t area = 0; area < areas.size(); ++area) {
    for (const std::size_t tree : areas[area].trees) {
      SpeciesMember member{.species = number_of(inventory, tree),
                           .plot = inventory.plot.code(tree),
                           .layer = options_.layers.layer_of(
                               inventory.h_m.empty() ? data::kMissing : inventory.h_m[tree]),
                           .represented = inventory.trees_represented(tree),
                           .basal_area_m2 = inventory.trees_represented(tree) *
                                            basal_area_m2(inventory.dbh_cm[tree])};
      if (options_.quadrat_m > 0.0) {
        const Window& window = *areas[area].window;
        const Point low = window.low();
        const Point high = window.high();
        const double side_m = options_.quadrat_m;
        const double off_m = window.rounding_m();
        member.quadrat = {area,
                          quadrat_of(inventory.x[tree] - low.x, high.x - low.x, side_m, off_m),
                          quadrat_of(inventory.y[tree] - low.y, high.y - low.y, side_m, off_m)};
      } else {
        member.quadrat = {member.plot, 0, 0};
      }
      members.push_back(member);
    }
  }
  return members;
}

/// \param layer  all trees if there is no such layer
void SpeciesSums::add_layer(const Inventory& inventory,
                            const std::vector<SpeciesMember>& members,
                            std::size_t layer) {
  std::vector<const SpeciesMember*> chosen;
  for (const SpeciesMember& member : members) {
    if (layer >= options_.layers.count() || member.layer == layer) chosen.push_back(&member);
  }
  const std::vector<std::uint32_t> plots = plots_in_order(inventory);
  std::vector<std::size_t> place(plots.size());
  for (std::size_t i = 0; i < plots.size(); ++i) place[plots[i]] = i;
  std::vector<std::vector<const SpeciesMember*>> by_plot(plots.size());
  for (const SpeciesMember* member : chosen) by_plot[place[member->plot]].push_back(member);
  layers_[layer].add(by_plot, chosen, species_.size());
}

void SpeciesSums::add(const Inventory& inventory, const std::vector<SampledArea>& areas) {
  check(areas);
  find_species(inventory);
  const std::vector<SpeciesMember> members = members_of(inventory, areas);
  has_heights_ = has_heights_ || !inventory.h_m.empty();
  layers_.resize(options_.layers.count() + 1);
  if (has_heights_) {
    for (std::size_t i = 0; i < options_.layers.count(); ++i) add_layer(inventory, members, i);
  }
  add_layer(inventory, members, options_.layers.count());
  std::vector<std::vector<std::size_t>> trees(species_.size());
  for (const SampledArea& area : areas) {
    for (const std::size_t tree : area.trees) trees[number_of(inventory, tree)].push_back(tree);
  }
  for (std::size_t i = 0; i < species_.size(); ++i) {
    species_[i].has_trees = species_[i].has_trees || !trees[i].empty();
    species_[i].figures.add(inventory, trees[i]);
  }
}

std::vector<SpeciesRow> SpeciesSums::rows(
    double area_m2,
    const std::function<void(std::size_t species, StandFigures&)>& set_dominant_height) const {
  std::vector<std::vector<Importance>> layers;
  for (const LayerSums& layer : layers_) layers.push_back(layer.importance());
  // In the order of first trees; those without species are the last.
  std::vector<std::size_t> order;
  for (std::size_t i = 1; i < species_.size(); ++i) order.push_back(i);
  std::ranges::stable_sort(order, {}, [this](std::size_t i) { return species_[i].first_line; });
  order.push_back(0);
  std::vector<SpeciesRow> rows;
  for (const std::size_t i : order) {
    if (!species_[i].has_trees) continue;
    SpeciesRow& row = rows.emplace_back();
    row.species = species_[i].name;
    row.figures = species_[i].figures.figures(area_m2);
    set_dominant_height(i, row.figures);
    row.basal_area_m2 = row.figures.basal_area_m2_per_ha * row.figures.area_ha;
    row.all = layers.back()[i];
    if (!has_heights_) continue;
    for (std::size_t layer = 0; layer < options_.layers.count(); ++layer) {
      row.layers.push_back(layers[layer][i]);
    }
  }
  std::ranges::stable_sort(
      rows, std::greater{}, [](const SpeciesRow& row) { return row.all.value; });
  return rows;
}

std::size_t Layers::layer_of(double height_m) const {
  if (std::isnan(height_m)) return count();
  const auto above = std::ranges::upper_bound(bounds_m, height_m);
  return static_cast<std::size_t>(above - bounds_m.begin());
}

std::string Layers::name_of(std::size_t layer) const {
  if (bounds_m.size() == 2) {
    constexpr const char* kNames[] = {"lower", "middle", "upper"};
    return kNames[layer];
  }
  if (bounds_m.empty()) return "all";
  if (layer == 0) return fmt::format("below {} m", bounds_m.front());
  if (layer == bounds_m.size()) return fmt::format("{} m and more", bounds_m.back());
  return fmt::format("{}-{} m", bounds_m[layer - 1], bounds_m[layer]);
}

std::vector<SpeciesRow> species_table(const Inventory& inventory,
                                      const std::vector<SampledArea>& areas,
                                      const SpeciesTableOptions& options) {
  SpeciesSums sums(options);
  sums.add(inventory, areas);
  std::vector<std::vector<std::size_t>> trees(sums.species_count());
  double area_m2 = 0.0;
  for (const SampledArea& area : areas) {
    area_m2 += area.area_m2;
    for (const std::size_t tree : area.trees) {
      trees[sums.number_of(inventory, tree)].push_back(tree);
    }
  }
  return sums.rows(area_m2, [&](std::size_t species, StandFigures& figures) {
    set_dominant_height(
        inventory, trees[species], options.dominant_trees_per_ha * figures.area_ha, figures);
  });
}

}  // namespace silvafit::stand
