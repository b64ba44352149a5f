// SPDX-License-Identifier: MIT
// Joint distributions of two indices.
#include "silvafit/stand/structure_classes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "silvafit/base/error.hpp"
#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;

TEST_CASE("joint distributions count core trees by both classes") {
  StructuralUnits units{.neighbors = 2,
                        .core = {1, 1, 1, 0, 1},
                        .W = {0.0, 0.5, 0.5, 1.0, NAN},
                        .M = {1.0, 0.0, 0.0, 1.0, 1.0}};
  const JointDistribution joint = joint_distribution(units, "W", "M");
  CHECK(joint.trees == 3);
  CHECK(joint.at(0, 2) == Approx(1.0 / 3.0).epsilon(1e-15));
  CHECK(joint.at(1, 0) == Approx(2.0 / 3.0).epsilon(1e-15));
  CHECK(std::accumulate(joint.share.begin(), joint.share.end(), 0.0) == Approx(1.0).epsilon(1e-15));
  units.weight = {2, 1, 1, 9, 1};
  CHECK(joint_distribution(units, "W", "M").at(0, 2) == 0.5);
  CHECK(std::isnan(joint_distribution(units, "C", "M").at(0, 0)));
  CHECK_THROWS_AS(joint_distribution(units, "T", "M"), silvafit::UsageError);
}
