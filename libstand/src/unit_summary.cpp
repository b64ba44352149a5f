// SPDX-License-Identifier: MIT
#include "silvafit/stand/unit_summary.hpp"

#include <cmath>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

struct Mean {
  double sum = 0.0;
  double weight = 0.0;

  void add(double value, double with_weight) {
    if (std::isnan(value)) return;
    sum += with_weight * value;
    weight += with_weight;
  }
  double value() const { return weight > 0.0 ? sum / weight : data::kMissing; }
};

struct Sums {
  std::size_t trees = 0;
  std::size_t core_trees = 0;
  Mean W{};
  Mean M{};
  Mean U{};
  Mean C{};
  std::vector<Mean> further{};

  void add(const StructuralUnits& units, std::size_t tree) {
    further.resize(units.further.size());
    ++trees;
    if (units.core[tree] == 0) return;
    ++core_trees;
    const double weight = units.weight_of(tree);
    W.add(units.W[tree], weight);
    M.add(units.M[tree], weight);
    U.add(units.U[tree], weight);
    if (!units.C.empty()) C.add(units.C[tree], weight);
    for (std::size_t i = 0; i < further.size(); ++i) {
      further[i].add(units.further[i].values[tree], weight);
    }
  }

  UnitSummary summary(std::string species) const {
    UnitSummary result{.species = std::move(species),
                       .trees = trees,
                       .core_trees = core_trees,
                       .W = W.value(),
                       .M = M.value(),
                       .U = U.value(),
                       .C = C.value()};
    for (const Mean& mean : further) result.further.push_back(mean.value());
    return result;
  }
};

}  // namespace

std::vector<UnitSummary> summarize_by_species(const Inventory& inventory,
                                              const StructuralUnits& units) {
  const std::vector<std::string>& names = inventory.species.levels();
  std::vector<Sums> sums(names.size() + 1);
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const bool is_named = !inventory.species.is_missing(tree);
    sums[is_named ? inventory.species.code(tree) : names.size()].add(units, tree);
  }
  std::vector<UnitSummary> summaries;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (sums[i].trees > 0) summaries.push_back(sums[i].summary(i < names.size() ? names[i] : ""));
  }
  return summaries;
}

UnitSummary summarize_all(const Inventory& inventory, const StructuralUnits& units) {
  Sums sums;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) sums.add(units, tree);
  return sums.summary("");
}

}  // namespace silvafit::stand
