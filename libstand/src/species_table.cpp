// SPDX-License-Identifier: MIT
#include "silvafit/stand/species_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "density_indices.hpp"
#include "moments.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

/// The data of a tree for importance values.
struct SpeciesMember {
  std::size_t species = 0;  ///< code; the number of species for trees without species
  std::size_t plot = 0;
  std::size_t layer = 0;
  double represented = 1.0;  ///< trees
  double basal_area_m2 = 0.0;
  /// Area, and quadrat within it, or the plot.
  std::tuple<std::size_t, long long, long long> quadrat{};
};

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

/// Importance values of all species among some trees, by code.
std::vector<Importance> importance_of(const std::vector<const SpeciesMember*>& members,
                                      std::size_t species_count) {
  std::vector<Importance> result(species_count);
  std::set<std::pair<std::size_t, std::tuple<std::size_t, long long, long long>>> occurrences;
  double basal_m2 = 0.0;
  double stems = 0.0;
  for (const SpeciesMember* member : members) {
    result[member->species].relative_density += member->represented;
    stems += member->represented;
    result[member->species].relative_dominance += member->basal_area_m2;
    basal_m2 += member->basal_area_m2;
    occurrences.emplace(member->species, member->quadrat);
  }
  // The number of quadrats cancels: only the number of quadrats with each species matters.
  for (const auto& [species, quadrat] : occurrences) result[species].relative_frequency += 1.0;
  if (members.empty()) return result;
  for (Importance& importance : result) {
    importance.relative_density *= 100.0 / stems;
    importance.relative_frequency *= 100.0 / static_cast<double>(occurrences.size());
    importance.relative_dominance *= 100.0 / basal_m2;
    importance.value = (importance.relative_density + importance.relative_frequency +
                        importance.relative_dominance) /
                       3.0;
  }
  return result;
}

/// With means and standard deviations over plots.
std::vector<Importance> importance_with_plots(const std::vector<const SpeciesMember*>& members,
                                              std::size_t species_count,
                                              std::size_t plot_count) {
  std::vector<Importance> result = importance_of(members, species_count);
  std::vector<std::vector<const SpeciesMember*>> by_plot(plot_count);
  for (const SpeciesMember* member : members) by_plot[member->plot].push_back(member);
  std::vector<Moments> moments(species_count);
  for (const auto& plot : by_plot) {
    // A plot without trees in this layer has no composition and is skipped.
    if (plot.empty()) continue;
    const std::vector<Importance> own = importance_of(plot, species_count);
    for (std::size_t i = 0; i < species_count; ++i) moments[i].add(own[i].value);
  }
  for (std::size_t i = 0; i < species_count; ++i) {
    result[i].plot_mean = moments[i].mean();
    result[i].plot_sd = moments[i].standard_deviation();
  }
  return result;
}

class TableMaker {
 public:
  TableMaker(const Inventory& inventory,
             const std::vector<SampledArea>& areas,
             const SpeciesTableOptions& options)
      : inventory_(inventory), areas_(areas), options_(options) {}

  std::vector<SpeciesRow> run();

 private:
  void check() const;
  void add_members();
  std::vector<Importance> importance(std::size_t layer) const;

  const Inventory& inventory_;
  const std::vector<SampledArea>& areas_;
  const SpeciesTableOptions& options_;
  std::size_t species_count_ = inventory_.species.levels().size() + 1;
  std::vector<SpeciesMember> members_{};
  std::vector<std::vector<std::size_t>> trees_of_species_{};
};

void TableMaker::check() const {
  const std::vector<double>& bounds = options_.layers.bounds_m;
  const bool is_ascending =
      std::ranges::adjacent_find(bounds, std::greater_equal{}) == bounds.end() &&
      std::ranges::all_of(bounds, [](double bound) { return bound > 0.0 && std::isfinite(bound); });
  if (!is_ascending) {
    throw UsageError("layer limits must be above 0 m and increasing", {.column = "--layers"});
  }
  if (!(options_.dominant_trees_per_ha > 0.0) || std::isinf(options_.dominant_trees_per_ha)) {
    throw UsageError(fmt::format("{} trees per ha must be above 0", options_.dominant_trees_per_ha),
                     {.column = "--dominant-trees"});
  }
  if (!(options_.quadrat_m >= 0.0) || std::isinf(options_.quadrat_m)) {
    throw UsageError(fmt::format("{} m must be 0 or more", options_.quadrat_m),
                     {.column = "--quadrat"});
  }
  const bool has_windows =
      std::ranges::all_of(areas_, [](const SampledArea& area) { return area.window.has_value(); });
  if (options_.quadrat_m > 0.0 && !has_windows) {
    throw UsageError(
        "quadrats need windows, not --plot-area: give --window or --circle instead, or omit "
        "--quadrat to use the plots as quadrats",
        {.column = "--quadrat"});
  }
}

void TableMaker::add_members() {
  trees_of_species_.resize(species_count_);
  for (std::size_t area = 0; area < areas_.size(); ++area) {
    for (const std::size_t tree : areas_[area].trees) {
      SpeciesMember member{
          .species = inventory_.species.is_missing(tree) ? species_count_ - 1
                                                         : inventory_.species.code(tree),
          .plot = inventory_.plot.code(tree),
          .layer = options_.layers.layer_of(inventory_.h_m.empty() ? data::kMissing
                                                                   : inventory_.h_m[tree]),
          .represented = inventory_.trees_represented(tree),
          .basal_area_m2 =
              inventory_.trees_represented(tree) * basal_area_m2(inventory_.dbh_cm[tree])};
      if (options_.quadrat_m > 0.0) {
        const Window& window = *areas_[area].window;
        const Point low = window.low();
        const Point high = window.high();
        const double side_m = options_.quadrat_m;
        const double off_m = window.rounding_m();
        member.quadrat = {area,
                          quadrat_of(inventory_.x[tree] - low.x, high.x - low.x, side_m, off_m),
                          quadrat_of(inventory_.y[tree] - low.y, high.y - low.y, side_m, off_m)};
      } else {
        member.quadrat = {member.plot, 0, 0};
      }
      members_.push_back(member);
      trees_of_species_[member.species].push_back(tree);
    }
  }
}

/// Of one layer, or of all trees if there is no such layer.
std::vector<Importance> TableMaker::importance(std::size_t layer) const {
  std::vector<const SpeciesMember*> chosen;
  for (const SpeciesMember& member : members_) {
    if (layer >= options_.layers.count() || member.layer == layer) chosen.push_back(&member);
  }
  return importance_with_plots(chosen, species_count_, inventory_.plot.levels().size());
}

std::vector<SpeciesRow> TableMaker::run() {
  check();
  add_members();
  double area_m2 = 0.0;
  for (const SampledArea& area : areas_) area_m2 += area.area_m2;
  const std::vector<Importance> all = importance(options_.layers.count());
  std::vector<std::vector<Importance>> layers;
  if (!inventory_.h_m.empty()) {
    for (std::size_t i = 0; i < options_.layers.count(); ++i) layers.push_back(importance(i));
  }
  std::vector<SpeciesRow> rows;
  for (std::size_t i = 0; i < species_count_; ++i) {
    if (trees_of_species_[i].empty()) continue;
    SpeciesRow& row = rows.emplace_back();
    if (i + 1 < species_count_) row.species = inventory_.species.levels()[i];
    row.figures =
        stand_figures(inventory_, trees_of_species_[i], area_m2, options_.dominant_trees_per_ha);
    row.basal_area_m2 = row.figures.basal_area_m2_per_ha * row.figures.area_ha;
    row.all = all[i];
    for (const auto& layer : layers) row.layers.push_back(layer[i]);
  }
  std::ranges::stable_sort(
      rows, std::greater{}, [](const SpeciesRow& row) { return row.all.value; });
  return rows;
}

}  // namespace

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
  return TableMaker(inventory, areas, options).run();
}

}  // namespace silvafit::stand
