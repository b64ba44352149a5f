// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "silvafit/tree/taper.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

TEST_CASE("The volume of a stem whose taper is a power has a closed form") {
  // d = dbh ((h - x) / (h - 1.3))^p: the integral of pi/4 d^2 over 0 .. h.
  const Taper moso = Taper::load(test::source_file("models/taper/moso.json"));
  constexpr double kPower = 0.72;
  for (const double h : {9.0, 15.0, 30.0}) {
    const double dbh_m = 0.1;
    const double exact = M_PI / 4.0 * dbh_m * dbh_m * std::pow(h, 2 * kPower + 1) /
                         ((2 * kPower + 1) * std::pow(h - 1.3, 2 * kPower));
    // The power is not smooth at the tip, but the volume there is tiny.
    CHECK(stem_volume_m3(moso, h, 10.0) == Approx(exact).epsilon(1e-6));
  }
}

TEST_CASE("The volume of a stem is that of many thin slices") {
  const Taper zeng = Taper::load(test::source_file("models/taper/zeng.json"));
  for (const auto& [h, dbh] : {std::pair(3.0, 2.5), std::pair(12.0, 22.0), std::pair(35.0, 22.0)}) {
    constexpr int kSlices = 200000;
    double sum = 0.0;
    std::vector<double> heights;
    for (int i = 0; i < kSlices; ++i) heights.push_back(h * (i + 0.5) / kSlices);
    for (const double d : zeng.diameters_cm(heights, h, dbh)) {
      sum += M_PI / 4.0 * d * d / 1e4 * h / kSlices;
    }
    // The slope of the stem is discontinuous at the limit of the butt; this matters in small trees.
    CHECK(stem_volume_m3(zeng, h, dbh) == Approx(sum).epsilon(1e-4));
  }
}
