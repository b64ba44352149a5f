// SPDX-License-Identifier: MIT
// How evenly the leaves of a tree are distributed over the surface of its crown.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

constexpr std::size_t kSectors = 8;
constexpr std::size_t kLayers = 6;
using Cells = std::array<double, kSectors * kLayers>;

double azimuth_of(std::size_t sector, double part) {
  return 2.0 * std::numbers::pi * (static_cast<double>(sector) + part) / kSectors;
}

/// The area of the crown's surface in each cell, as a proportion of the whole. The stem's axis
/// divides the crown into sectors, horizontal planes divide its length into layers.
Cells surface_of(const Crown& crown) {
  Cells surface{};
  double sum = 0.0;
  for (std::size_t layer = 0; layer < kLayers; ++layer) {
    const double share = (static_cast<double>(layer) + 0.5) / kLayers;
    const double z = crown.hcb_m() + share * (crown.h_m() - crown.hcb_m());
    for (std::size_t sector = 0; sector < kSectors; ++sector) {
      const double azimuth = azimuth_of(sector, 0.5);
      const double radius = crown.radius_m(std::cos(azimuth), std::sin(azimuth));
      surface[layer * kSectors + sector] = radius * crown.relative_width(z);
      sum += surface[layer * kSectors + sector];
    }
  }
  for (double& cell : surface) cell /= sum;
  return surface;
}

/// The leaf area of each cell as a proportion of the whole.
Cells leaves_of(const MeshPart& foliage, const Crown& crown) {
  Cells leaves{};
  double sum = 0.0;
  for (std::size_t i = 0; i < foliage.triangle_count(); ++i) {
    const auto [a, b, c] = test::triangle_of(foliage, i);
    const Point middle = (1.0 / 3.0) * (a + b + c);
    const double area = length(cross(b - a, c - a));
    const double azimuth = std::atan2(middle.y, middle.x) + 2.0 * std::numbers::pi;
    const double share = (middle.z - crown.hcb_m()) / (crown.h_m() - crown.hcb_m());
    const auto sector = static_cast<std::size_t>(azimuth / (2.0 * std::numbers::pi) * kSectors);
    const auto layer = static_cast<std::size_t>(std::clamp(share * kLayers, 0.0, kLayers - 1.0));
    leaves[layer * kSectors + sector % kSectors] += area;
    sum += area;
  }
  for (double& cell : leaves) cell /= sum;
  return leaves;
}

/// What the cells of a tree's crown above the lowest layer have of the leaf area that would be
/// theirs if it were even. The lowest layer is a point below, where a single branch starts.
std::vector<double> cover_of(const Morphology& tree, const Preset& preset) {
  const SceneTree grown = grow_tree(tree, preset, {.mesh = {.textured = true}});
  REQUIRE(grown.mesh.parts.back().kind == PartKind::kFoliage);
  const Crown crown(complete(tree, preset.relative_hc, ""), preset.crown_index);
  const Cells surface = surface_of(crown);
  const Cells leaves = leaves_of(grown.mesh.parts.back(), crown);
  std::vector<double> cover;
  for (std::size_t i = kSectors; i < leaves.size(); ++i) cover.push_back(leaves[i] / surface[i]);
  return cover;
}

/// Pairs of neighboring cells in one layer, or one above the other, that both are nearly bare.
std::size_t large_gaps(const std::vector<double>& cover) {
  constexpr double kBare = 0.1;
  std::size_t gaps = 0;
  for (std::size_t i = 0; i < cover.size(); ++i) {
    if (cover[i] >= kBare) continue;
    const std::size_t first = i - i % kSectors;
    const std::size_t beside = first + (i + 1) % kSectors;
    const std::size_t above = i + kSectors;
    gaps += cover[beside] < kBare ? 1 : 0;
    gaps += above < cover.size() && cover[above] < kBare ? 1 : 0;
  }
  return gaps;
}

}  // namespace

TEST_CASE("the crowns of broadleaves have no large gaps") {
  const std::array<Morphology, 5> shapes{{
      {.plot = "usual", .dbh_cm = 24, .h_m = 16, .hcb_m = 4.5, .cw_m = 8},
      {.plot = "slender", .dbh_cm = 20, .h_m = 18, .hcb_m = 3, .cw_m = 5},
      {.plot = "wide", .dbh_cm = 40, .h_m = 16, .hcb_m = 0.3, .cw_m = 14},
      {.plot = "high", .dbh_cm = 30, .h_m = 20, .hcb_m = 8, .cw_m = 9},
      {.plot = "unequal radii",
       .dbh_cm = 24,
       .h_m = 16,
       .hcb_m = 4.5,
       .radii = CrownRadii{5.5, 2.5, 3.0, 5.0}},
  }};
  constexpr int kTrees = 20;
  for (const char* name : {"generic-broadleaf", "machilus-pauhoi", "schima-superba"}) {
    for (Morphology tree : shapes) {
      std::size_t bare = 0;
      std::size_t gaps = 0;
      for (int i = 0; i < kTrees; ++i) {
        tree.tree = std::to_string(i);
        const std::vector<double> cover = cover_of(tree, test::shipped_presets().named(name));
        bare += static_cast<std::size_t>(
            std::count_if(cover.begin(), cover.end(), [](double cell) { return cell < 0.2; }));
        gaps += large_gaps(cover);
      }
      INFO(name << ", " << tree.plot << ": " << bare << " of " << kTrees * 40
                << " cells are nearly bare, " << gaps << " pairs of neighbors");
      // Without the choice of buds by the gaps, up to 112 cells and 47 pairs.
      CHECK(bare <= 56);
      CHECK(gaps <= 6);
    }
  }
}
