// SPDX-License-Identifier: MIT
// The requirement of every builder: the mesh of a tree has its measurements.
#pragma once

#include <catch2/catch.hpp>

#include "silvafit/tree/scene.hpp"

namespace silvafit::test {

/// The four radii that were measured, or half the crown's width.
inline tree::CrownRadii radii_of(const tree::Morphology& tree) {
  if (tree.radii) return *tree.radii;
  const double radius = 0.5 * *tree.cw_m;
  return {radius, radius, radius, radius};
}

inline tree::CrownRadii radii_of(const tree::TreeShape& shape) { return shape.radii; }

/// To a centimeter, and DBH to a millimeter (docs/trees.md).
/// \tparam Tree  a morphology, or the shape that completes one
template <typename Tree>
void check_mesh_measurements(const Tree& tree, const tree::Measurements& measured) {
  const tree::CrownRadii radii = radii_of(tree);
  INFO("h " << tree.h_m << " hcb " << tree.hcb_m << " dbh " << tree.dbh_cm << " radii "
            << radii.east_m << ' ' << radii.west_m << ' ' << radii.south_m << ' ' << radii.north_m);
  REQUIRE(measured.h_m == Approx(tree.h_m).margin(0.01));
  REQUIRE(measured.hcb_m == Approx(tree.hcb_m).margin(0.01));
  REQUIRE(measured.dbh_cm == Approx(tree.dbh_cm).margin(0.1));
  REQUIRE(measured.radii.east_m == Approx(radii.east_m).margin(0.01));
  REQUIRE(measured.radii.west_m == Approx(radii.west_m).margin(0.01));
  REQUIRE(measured.radii.south_m == Approx(radii.south_m).margin(0.01));
  REQUIRE(measured.radii.north_m == Approx(radii.north_m).margin(0.01));
}

inline void check_mesh_measurements(const tree::Morphology& tree, const tree::SceneTree& grown) {
  INFO(tree.plot << "-" << tree.tree << ' ' << grown.preset << " hc " << tree.hc_m.value_or(-1));
  check_mesh_measurements(tree, grown.measured);
}

}  // namespace silvafit::test
