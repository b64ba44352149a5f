// SPDX-License-Identifier: MIT
#include "silvafit/tree/fitted_skeleton.hpp"

#include "fitted_test_support.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::tree;
using namespace silvafit::test;

TEST_CASE("any skeleton comes to the measurements of any legal tree") {
  Random random(51);
  for (const Skeleton& grown : all_kinds()) {
    for (int i = 0; i < 100; ++i) {
      const CrownIndex index{random.uniform(1.0, 2.0), random.uniform(1.0, 2.0)};
      check_fitted(
          fitted(grown, test::random_morphology(random, i), i % 2 == 0 ? CrownIndex{} : index));
    }
  }
}

TEST_CASE("a skeleton without a rising stem or a branch is refused") {
  const auto fit = [](const Skeleton& grown) { return fitted(grown, test::paper_tree_1()); };
  CHECK_THROWS_AS(fit({}), GeometryError);
  HandMade bare;
  bare.axis(0, {{{0, 0, 0}, 1}, {{0, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(bare.take()), GeometryError);
  HandMade lying;
  lying.axis(0, {{{0, 0, 0}, 1}, {{1, 0, 0}, 1}});
  lying.axis(0, {{{0.5, 0, 0}, 1}, {{0.5, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(lying.take()), GeometryError);
  HandMade broken;
  broken.axis(0, {{{0, 0, 0}, 1}, {{0, 0, NAN}, 1}});
  broken.axis(0, {{{0, 0, 0}, 1}, {{1, 0, 1}, 1}});
  CHECK_THROWS_AS(fit(broken.take()), GeometryError);
}
