// SPDX-License-Identifier: MIT
#include "silvafit/stand/unit_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "silvafit/data/table.hpp"
#include "trees/plot_order.hpp"

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
  std::uint32_t first_line = std::numeric_limits<std::uint32_t>::max();
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

struct UnitSummaries::State {
  Sums all{};
  std::vector<std::string> names{};  ///< in the order of first trees
  std::unordered_map<std::string, std::size_t> number_of{};
  std::vector<Sums> by_species{};
  Sums without_species{};
};

UnitSummaries::UnitSummaries() : state_(std::make_unique<State>()) {}
UnitSummaries::~UnitSummaries() = default;
UnitSummaries::UnitSummaries(UnitSummaries&&) noexcept = default;
UnitSummaries& UnitSummaries::operator=(UnitSummaries&&) noexcept = default;

void UnitSummaries::add(const Inventory& inventory, const StructuralUnits& units) {
  State& state = *state_;
  std::vector<std::size_t> numbers;
  for (const std::string& name : inventory.species.levels()) {
    const auto [entry, is_new] = state.number_of.try_emplace(name, state.names.size());
    if (is_new) {
      state.names.push_back(name);
      state.by_species.emplace_back();
    }
    numbers.push_back(entry->second);
  }
  // Plot by plot, as parts of a file come, so that sums have the same last digits.
  for (const std::size_t tree : rows_in_plot_order(inventory)) {
    state.all.add(units, tree);
    const bool is_named = !inventory.species.is_missing(tree);
    Sums& own =
        is_named ? state.by_species[numbers[inventory.species.code(tree)]] : state.without_species;
    own.add(units, tree);
    if (!inventory.lines.empty()) own.first_line = std::min(own.first_line, inventory.lines[tree]);
  }
}

std::vector<UnitSummary> UnitSummaries::by_species() const {
  std::vector<std::size_t> order(state_->names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(
      order, {}, [this](std::size_t i) { return state_->by_species[i].first_line; });
  std::vector<UnitSummary> summaries;
  for (const std::size_t i : order) {
    if (state_->by_species[i].trees == 0) continue;
    summaries.push_back(state_->by_species[i].summary(state_->names[i]));
  }
  if (state_->without_species.trees > 0) summaries.push_back(state_->without_species.summary(""));
  return summaries;
}

UnitSummary UnitSummaries::all() const { return state_->all.summary(""); }

}  // namespace silvafit::stand
