// SPDX-License-Identifier: MIT
// Culms of the moso preset, for the tests of the bamboo builder.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bamboo/bamboo.hpp"
#include "test_support/tree_test_support.hpp"

namespace silvafit::test {

inline const tree::BambooBuilder& moso() {
  return dynamic_cast<const tree::BambooBuilder&>(
      shipped_builders().named(tree::BuilderKind::kBamboo, "moso"));
}

/// A grown culm: 10 cm, 14 m, its crown from 8 m up, 2.6 m wide.
inline tree::Morphology usual_culm(const std::string& name = "1") {
  return {.plot = "1",
          .tree = name,
          .species = "Phyllostachys edulis",
          .dbh_cm = 10.0,
          .h_m = 14.0,
          .hcb_m = 8.0,
          .cw_m = 2.6};
}

struct Bamboo {
  tree::TreeShape shape;
  tree::Crown crown;
  tree::Skeleton skeleton;
};

inline Bamboo grown(const tree::Morphology& morphology, std::uint64_t seed = 1) {
  tree::TreeShape shape = moso().shape_of(morphology);
  tree::Crown crown(shape, moso().preset().crown_index);
  Random random = tree::random_of_tree(seed, morphology.plot, morphology.tree);
  tree::Skeleton skeleton = moso().grow_skeleton(shape, crown, random);
  return {std::move(shape), std::move(crown), std::move(skeleton)};
}

}  // namespace silvafit::test
