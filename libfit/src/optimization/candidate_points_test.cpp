// SPDX-License-Identifier: MIT
#include "optimization/candidate_points.hpp"

#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;

TEST_CASE("no two coordinates of the points of a search are the same sequence") {
  data::Table table;
  table.set("x", std::vector<double>{1.0, 2.0, 3.0});
  table.set("y", std::vector<double>{1.0, 2.0, 3.0});
  const NonlinearModel model(specify_model({.formula = "y ~ a*x"}, table), table);
  constexpr Eigen::Index kCoefficients = 40;
  const CandidatePoints points(model, kCoefficients);
  std::set<std::vector<double>> sequences;
  for (Eigen::Index k = 0; k < kCoefficients; ++k) {
    std::vector<double> sequence;
    int positive = 0;
    for (std::size_t number = 1; number <= 100; ++number) {
      sequence.push_back(points(number)[k]);
      positive += sequence.back() > 0.0 ? 1 : 0;
    }
    sequences.insert(sequence);
    // Half of them, up to the discrepancy of the sequences.
    CHECK(positive >= 40);
    CHECK(positive <= 60);
  }
  CHECK(sequences.size() == kCoefficients);
}
