// SPDX-License-Identifier: MIT
#include "mesh/level_of_detail.hpp"

#include <array>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

struct Level {
  int stem_sides;
  int branch_sides;
  double stem_tolerance_m;
  double branch_tolerance_m;
  int wood_order;
  int foliage_per;
};

constexpr std::array<Level, kLevelsOfDetail> kLevels{{
    {12, 6, 0.0005, 0.0, kAllOrders, 1},
    {8, 4, 0.002, 0.005, 6, 2},
    {6, 3, 0.01, 0.03, 3, 4},
    {4, 3, 0.03, 0.2, 1, 8},
}};

}  // namespace

bool has_same_wood(const MeshOptions& a, const MeshOptions& b) {
  return a.stem_sides == b.stem_sides && a.branch_sides == b.branch_sides &&
         a.twig_sides == b.twig_sides && a.thick_branch_m == b.thick_branch_m &&
         a.stem_tolerance_m == b.stem_tolerance_m && a.branch_tolerance_m == b.branch_tolerance_m &&
         a.wood_order == b.wood_order;
}

MeshOptions level_of_detail(int level, const MeshOptions& base) {
  if (level < 0 || level >= kLevelsOfDetail) {
    throw UsageError("a level of detail must be from 0 (finest) to " +
                     std::to_string(kLevelsOfDetail - 1) + ", not " + std::to_string(level));
  }
  const Level& of = kLevels[static_cast<std::size_t>(level)];
  MeshOptions options = base;
  options.stem_sides = of.stem_sides;
  options.branch_sides = of.branch_sides;
  options.twig_sides = 3;
  options.thick_branch_m = MeshOptions{}.thick_branch_m;
  options.stem_tolerance_m = of.stem_tolerance_m;
  options.branch_tolerance_m = of.branch_tolerance_m;
  options.wood_order = of.wood_order;
  options.foliage_per = of.foliage_per;
  return options;
}

}  // namespace silvafit::tree
