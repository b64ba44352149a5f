// SPDX-License-Identifier: MIT
// Clark and Evans's index against lattices and random stands.
#include "silvafit/stand/clark_evans.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

#include "silvafit/base/random.hpp"

using namespace silvafit::stand;

TEST_CASE("Clark and Evans's index distinguishes lattices from clusters") {
  std::vector<Point> lattice;
  std::vector<Point> pairs;
  for (int i = 0; i < 20; ++i) {
    const int pair = i / 2;
    for (int j = 0; j < 20; ++j) {
      lattice.push_back({5.0 * i + 2.5, 5.0 * j + 2.5});
      pairs.push_back({10.0 * pair + 0.01 * (i % 2) + 5.0, 5.0 * j + 2.5});
    }
  }
  const Window window = Window::rectangle({0, 0}, {100, 100});
  // A square lattice has R = 2; on the triangular one it is 2.149.
  CHECK(clark_evans(lattice, window).R == Approx(2.0).epsilon(1e-12));
  CHECK(clark_evans(lattice, window).p < 1e-10);
  CHECK(clark_evans(pairs, window).R < 0.01);
  CHECK(std::isnan(clark_evans(std::vector<Point>{{1, 1}}, window).R));
  // Stems at one place are at distance 0.
  CHECK(clark_evans(std::vector<Point>{{1, 1}, {1, 1}, {5, 5}}, window).mean_distance_m ==
        Approx(std::sqrt(32.0) / 3.0).epsilon(1e-14));
}

TEST_CASE("Donnelly's correction removes the edge effect in random stands") {
  double plain = 0.0;
  double corrected = 0.0;
  constexpr int kRounds = 200;
  for (int round = 0; round < kRounds; ++round) {
    silvafit::Random random(static_cast<std::uint64_t>(round));
    std::vector<Point> points;
    points.reserve(60);
    for (int i = 0; i < 60; ++i) points.push_back({random.uniform(0, 60), random.uniform(0, 40)});
    const ClarkEvans index = clark_evans(points, Window::rectangle({0, 0}, {60, 40}));
    plain += index.R / kRounds;
    corrected += index.R_donnelly / kRounds;
  }
  // Standard error of one index 0.52 / sqrt(60) = 0.067, of the mean 0.005.
  CHECK(corrected == Approx(1.0).margin(0.015));
  CHECK(plain > 1.03);
}
