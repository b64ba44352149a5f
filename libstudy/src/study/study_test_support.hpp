// SPDX-License-Identifier: MIT
// A small stand for the tests of studies: known heights, random plots, indices at random.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::test {

inline const study::Catalogue& catalogue() {
  static const study::Catalogue models = study::Catalogue::load(source_file("models"));
  return models;
}

struct StandDesign {
  std::size_t plots = 8;
  std::size_t trees = 30;  ///< of a plot
  bool has_indices = true;
  std::string species = "SM";
};

/// h = 1.3 + (25 + b)(1 - exp(-(0.06 - 0.02 C) dbh)) + e, b ~ N(0, 2^2) by plot, e ~ N(0, 0.7^2).
inline data::Table stand(const StandDesign& design) {
  Random random(11);
  data::TextColumn plots;
  data::TextColumn trees;
  data::TextColumn species;
  std::vector<double> dbh;
  std::vector<double> h;
  std::vector<std::vector<double>> indices(4);
  for (std::size_t plot = 1; plot <= design.plots; ++plot) {
    const double limit = random.normal(25.0, 2.0);
    for (std::size_t tree = 1; tree <= design.trees; ++tree) {
      plots.append(fmt::format("{:02}", plot));
      trees.append(std::to_string(tree));
      species.append(design.species);
      for (auto& index : indices) index.push_back(0.25 * static_cast<double>(random.below(5)));
      dbh.push_back(random.uniform(6.0, 45.0));
      const double rate = 0.06 - 0.02 * indices[2].back();
      h.push_back(1.3 + limit * (1.0 - std::exp(-rate * dbh.back())) + random.normal(0.0, 0.7));
    }
  }
  data::Table table;
  table.set("plot", std::move(plots));
  table.set("tree", std::move(trees));
  table.set("species", std::move(species));
  table.set("dbh", std::move(dbh));
  table.set("h", std::move(h));
  const std::vector<std::string> names{"W", "M", "C", "U"};
  for (std::size_t k = 0; design.has_indices && k < names.size(); ++k) {
    table.set(names[k], indices[k]);
  }
  return table;
}

}  // namespace silvafit::test
