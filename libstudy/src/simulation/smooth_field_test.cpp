// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "silvafit/base/random.hpp"
#include "simulation/simulated_stems.hpp"
#include "simulation/simulation_test_support.hpp"

using namespace silvafit;
using test::check_standard_normal;
using test::mean;

TEST_CASE("smooth fields have unit variance and the correlation of their length") {
  constexpr int kFields = 4000;
  Random random(3);
  std::vector<double> here;
  std::vector<double> products;
  for (int i = 0; i < kFields; ++i) {
    const study::SmoothField field(20.0, random);
    here.push_back(field(13.0, 41.0));
    products.push_back(here.back() * field(33.0, 41.0));
  }
  check_standard_normal(here);
  // Correlation exp(-d^2 / (2 length^2)) at d = length; the product's variance is at most 2.
  CHECK(std::abs(mean(products) - std::exp(-0.5)) < 4.0 * std::sqrt(2.0 / kFields));
}
