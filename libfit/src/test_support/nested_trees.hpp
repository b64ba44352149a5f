// SPDX-License-Identifier: MIT
// Trees of plots in stands, for tests of models with nested random effects.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::fit {

struct NestedTree {
  std::string stand{};
  std::string plot{};
  std::string_view species{};
  double dbh_cm = 0.0;
  double crowding = 0.0;
  double h_m = 0.0;
};

/// Columns stand, plot, species, dbh, C and h.
inline data::Table table_of(const std::vector<NestedTree>& trees) {
  data::TextColumn stand;
  data::TextColumn plot;
  data::TextColumn species;
  std::vector<double> dbh;
  std::vector<double> crowding;
  std::vector<double> h;
  for (const NestedTree& tree : trees) {
    stand.append(tree.stand);
    plot.append(tree.plot);
    species.append(tree.species);
    dbh.push_back(tree.dbh_cm);
    crowding.push_back(tree.crowding);
    h.push_back(tree.h_m);
  }
  data::Table table;
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("species", species);
  table.set("dbh", dbh);
  table.set("C", crowding);
  table.set("h", h);
  return table;
}

}  // namespace silvafit::fit
