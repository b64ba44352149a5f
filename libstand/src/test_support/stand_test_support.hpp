// SPDX-License-Identifier: MIT
// Small stands for tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "figures/figure_sums.hpp"
#include "figures/joint_sums.hpp"
#include "figures/plot_sums.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/stand/species_table.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"

namespace silvafit::stand::test {

struct Tree {
  double x = 0.0;
  double y = 0.0;
  double dbh_cm = 20.0;
  const char* species = "A";
  double cw_m = 1.0;
  std::string id{};  ///< default: the number in the list, from 1
  const char* plot = "1";
  double h_m = NAN;
};

inline Inventory stand_of(const std::vector<Tree>& trees) {
  Inventory inventory;
  for (const Tree& tree : trees) {
    inventory.plot.append(tree.plot);
    inventory.tree.append(tree.id.empty() ? std::to_string(inventory.size() + 1) : tree.id);
    if (tree.species == nullptr) {
      inventory.species.append_missing();
    } else {
      inventory.species.append(tree.species);
    }
    inventory.x.push_back(tree.x);
    inventory.y.push_back(tree.y);
    inventory.cw_m.push_back(tree.cw_m);
    inventory.dbh_cm.push_back(tree.dbh_cm);
    inventory.h_m.push_back(tree.h_m);
  }
  return inventory;
}

inline std::vector<std::size_t> all_rows(const Inventory& inventory) {
  std::vector<std::size_t> rows(inventory.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  return rows;
}

inline UnitSummaries summaries_of(const Inventory& inventory, const StructuralUnits& units) {
  UnitSummaries summaries;
  summaries.add(inventory, units);
  return summaries;
}

inline JointDistribution joint_distribution(const StructuralUnits& units,
                                            const std::string& first,
                                            const std::string& second) {
  std::vector<std::size_t> trees(units.core.size());
  std::iota(trees.begin(), trees.end(), std::size_t{0});
  JointSums sums(first, second);
  sums.add(units, trees);
  return sums.distribution();
}

inline std::vector<DiameterClass> diameter_distribution(const Inventory& inventory,
                                                        double area_m2,
                                                        double width_cm) {
  DiameterSums sums(width_cm);
  sums.add(inventory, all_rows(inventory));
  return sums.classes(area_m2);
}

inline std::vector<StratumFigures> stratum_figures(
    const Inventory& inventory,
    const std::vector<SampledArea>& areas,
    const std::vector<std::string>& stratum_of_area,
    const std::map<std::string, double>& stratum_areas_ha) {
  PlotSums plots;
  plots.add(inventory, areas);
  return stand::stratum_figures(plots, stratum_of_area, stratum_areas_ha, false, {});
}

inline double basal_area_m2(double dbh_cm) { return M_PI * dbh_cm * dbh_cm / 4e4; }

inline const SpeciesRow& row_of(const std::vector<SpeciesRow>& rows, const std::string& species) {
  const auto found = std::ranges::find(rows, species, &SpeciesRow::species);
  if (found == rows.end()) throw std::runtime_error("no species " + species);
  return *found;
}

inline StructuralUnitOptions without_edge(std::size_t neighbors = 4) {
  return {.neighbors = neighbors, .edge = EdgeCorrection::kNone};
}

/// Trees at random on 60 x 40 m.
inline std::vector<Tree> random_stand(std::size_t count, std::uint64_t seed) {
  silvafit::Random random(seed);
  constexpr std::array kSpecies{"A", "B", "C"};
  std::vector<Tree> trees;
  for (std::size_t i = 0; i < count; ++i) {
    trees.push_back({.x = random.uniform(0, 60),
                     .y = random.uniform(0, 40),
                     .dbh_cm = std::round(random.uniform(5, 30)),
                     .species = kSpecies[random.below(3)],
                     .cw_m = random.uniform(1, 5),
                     .id = std::to_string(i + 1),
                     .h_m = random.uniform(5, 30)});
  }
  return trees;
}

}  // namespace silvafit::stand::test
