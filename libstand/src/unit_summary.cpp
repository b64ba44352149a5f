// SPDX-License-Identifier: MIT
#include "silvafit/stand/unit_summary.hpp"

#include <cmath>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

struct Mean {
  double sum = 0.0;
  std::size_t count = 0;

  void add(double value) {
    if (std::isnan(value)) return;
    sum += value;
    ++count;
  }
  double value() const { return count == 0 ? data::kMissing : sum / static_cast<double>(count); }
};

struct Sums {
  std::size_t trees = 0;
  std::size_t core_trees = 0;
  Mean W{};
  Mean M{};
  Mean U{};
  Mean C{};

  void add(const StructuralUnits& units, std::size_t tree) {
    ++trees;
    if (units.core[tree] == 0) return;
    ++core_trees;
    W.add(units.W[tree]);
    M.add(units.M[tree]);
    U.add(units.U[tree]);
    if (!units.C.empty()) C.add(units.C[tree]);
  }

  UnitSummary summary(std::string species) const {
    return {.species = std::move(species),
            .trees = trees,
            .core_trees = core_trees,
            .W = W.value(),
            .M = M.value(),
            .U = U.value(),
            .C = C.value()};
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
