// SPDX-License-Identifier: MIT
#include "figures/dominant_trees.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

/// A number from 0 as a key by which larger numbers come first: the bits of doubles from 0 have
/// their order.
std::uint64_t falling(double value) { return ~std::bit_cast<std::uint64_t>(value); }

double value_of(std::uint64_t key) { return std::bit_cast<double>(~key); }

}  // namespace

void DominantTrees::add(double dbh_cm, double h_m, std::size_t species) {
  if (by_species_.size() <= species) by_species_.resize(species + 1);
  ++all_.trees;
  ++by_species_[species].trees;
  const auto number = static_cast<std::uint32_t>(species);
  char record[sizeof(number)];
  std::memcpy(record, &number, sizeof(number));
  // Among equally thick trees, those without height are last.
  sorted_.add({falling(dbh_cm), falling(std::isnan(h_m) ? 0.0 : h_m)},
              std::string_view(record, sizeof(number)));
}

void DominantTrees::find(double wanted) {
  if (std::isnan(wanted)) return;
  const auto count_of = [wanted](const Group& group) {
    return std::min(group.trees,
                    std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(wanted))));
  };
  const auto take = [](double dbh_cm, double h_m, std::size_t count, Group& group) {
    if (group.dominant.trees() < count) group.dominant.add(dbh_cm, h_m);
  };
  std::vector<std::size_t> counts;
  for (const Group& group : by_species_) counts.push_back(count_of(group));
  ExternalSort::Key key;
  std::string record;
  while (sorted_.next(key, record)) {
    std::uint32_t species = 0;
    std::memcpy(&species, record.data(), sizeof(species));
    const double dbh_cm = value_of(key.first);
    const double h_m = key.second == falling(0.0) ? data::kMissing : value_of(key.second);
    take(dbh_cm, h_m, count_of(all_), all_);
    take(dbh_cm, h_m, counts[species], by_species_[species]);
  }
}

void DominantTrees::set_of_species(std::size_t species, StandFigures& figures) const {
  (species < by_species_.size() ? by_species_[species] : Group()).dominant.set(figures);
}

}  // namespace silvafit::stand
