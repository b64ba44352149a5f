// SPDX-License-Identifier: MIT
// A design for the tests of simulated stands, and checks of samples. Bounds of 4 standard
// errors: with the fixed seed the result is always the same; one of 16,000 other seeds would fail.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "silvafit/study/simulate.hpp"

namespace silvafit::test {

/// One species with responses far from all limits, on 100 m x 100 m.
inline nlohmann::json plain_design() {
  return nlohmann::json::parse(R"({
    "schema": "silvafit-design/1",
    "plots": {"grid": {"columns": 2, "rows": 2, "width": 50, "height": 50}},
    "stems": {"minimum_distance": 0.7, "patch_length": 15},
    "species": [{
      "code": "A", "density": 3000,
      "dbh": {"minimum": 5, "mean": 24.86, "sd": 8.91},
      "h": {"formula": "h ~ a + b*dbh", "fixed": {"a": 30, "b": 0.5}, "sigma": 1},
      "hcb": {"formula": "hcb ~ a*h", "fixed": {"a": 0.5}, "sigma": 1},
      "cw": {"formula": "cw ~ a + b*dbh", "fixed": {"a": 3, "b": 0.05}, "sigma": 0.2}
    }]
  })");
}

inline study::SimulatedStand stand_of(const nlohmann::json& design, std::uint64_t seed = 1) {
  return study::simulate(study::parse_design(design.dump(), "design.json"), seed);
}

inline double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

inline double variance(const std::vector<double>& values) {
  const double center = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - center) * (value - center);
  return sum / static_cast<double>(values.size() - 1);
}

/// Checks for mean 0 and variance 1, as of standard normal variates.
inline void check_standard_normal(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  CHECK(std::abs(mean(values)) < 4.0 / std::sqrt(n));
  CHECK(std::abs(variance(values) - 1.0) < 4.0 * std::sqrt(2.0 / n));
}

}  // namespace silvafit::test
