// SPDX-License-Identifier: MIT
#include "silvafit/base/median.hpp"

#include <catch2/catch.hpp>

using silvafit::median;

TEST_CASE("the median is the value in the middle, or the mean of the two there", "[base]") {
  CHECK(median({7.0}) == 7.0);
  CHECK(median({9.0, 1.0, 4.0}) == 4.0);
  CHECK(median({9.0, 1.0, 4.0, 2.0}) == 3.0);
  CHECK(median({-1.0, -1.0, 5.0, 5.0}) == 2.0);
  CHECK(median({3.0, 3.0, 3.0, 8.0, 0.0, 3.0}) == 3.0);
}
