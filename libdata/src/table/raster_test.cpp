// SPDX-License-Identifier: MIT
#include "silvafit/data/raster.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace silvafit::data {
namespace {

// Centers at x = 10, 12, 14 and y = 105, 100.
Raster raster() {
  return {.west = 10.0,
          .north = 105.0,
          .step_x = 2.0,
          .step_y = 5.0,
          .columns = 3,
          .rows = 2,
          .values = {1.0F, 3.0F, 5.0F, 11.0F, 13.0F, std::numeric_limits<float>::quiet_NaN()}};
}

TEST_CASE("a raster is bilinear between the centers of its cells") {
  const Raster terrain = raster();
  CHECK(terrain.at(10.0, 105.0) == 1.0);
  CHECK(terrain.at(14.0, 105.0) == 5.0);
  CHECK(terrain.at(12.0, 100.0) == 13.0);
  // A quarter to the east and two fifths to the south: 1 + 2/4 + 10 * 2/5.
  CHECK(terrain.at(10.5, 103.0) == Approx(5.5).epsilon(1e-15));
}

TEST_CASE("a raster reaches half a cell beyond its centers") {
  const Raster terrain = raster();
  CHECK(terrain.at(9.0, 107.5) == 1.0);
  CHECK(terrain.at(9.0, 97.5) == 11.0);
  CHECK(std::isnan(terrain.at(8.9, 105.0)));
  CHECK(std::isnan(terrain.at(15.1, 105.0)));
  CHECK(std::isnan(terrain.at(10.0, 97.4)));
  CHECK(std::isnan(terrain.at(std::nan(""), 100.0)));
}

TEST_CASE("unknown cells make their surroundings unknown, and no others") {
  const Raster terrain = raster();
  CHECK(std::isnan(terrain.at(13.0, 102.0)));
  CHECK(std::isnan(terrain.at(14.0, 100.0)));
  CHECK(terrain.at(13.0, 105.0) == 4.0);
  CHECK(terrain.at(12.0, 102.5) == 8.0);
}

}  // namespace
}  // namespace silvafit::data
