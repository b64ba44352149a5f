// SPDX-License-Identifier: MIT
#include "silvafit/tree/smooth_mesh.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "mesh_test_support.hpp"
#include "silvafit/base/error.hpp"
#include "smooth_mesh_limbs.hpp"
#include "smooth_mesh_tube.hpp"
#include "tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

/// Leaves of two grades at the tips of all axes and along them.
void add_leaves(Skeleton& skeleton) {
  for (std::uint32_t i = 1; i < skeleton.axes.size(); ++i) {
    const auto points = skeleton.points_of(skeleton.axes[i]);
    const Point along = direction(points.back().at - points.front().at);
    const Point facing = direction(cross(along, {0.3, 0.5, 0.1}));
    for (const SkeletonPoint& point : points.subspan(1)) {
      skeleton.leaves.push_back({.at = point.at,
                                 .along = along,
                                 .facing = facing,
                                 .length_m = 0.08,
                                 .axis = i,
                                 .grade = i % 2});
    }
  }
}

SmoothStyle style_with(LeafForm first, LeafForm second) {
  return {.bark = {0.2, 0.1, 0.05},
          .leaves = {{.form = first, .color = {0.05, 0.2, 0.02}},
                     {.form = second, .aspect = 0.2, .color = {0.1, 0.3, 0.05}}}};
}

/// A fitted skeleton with leaves: that of a preset of the segment builder.
test::Stages fitted(const Morphology& morphology, const Preset& preset) {
  test::Stages stages = test::stages_of(morphology, preset);
  add_leaves(stages.skeleton);
  return stages;
}

Mesh mesh_of(const test::Stages& stages,
             const MeshOptions& options = {},
             LeafForm first = LeafForm::kFivePolygons,
             LeafForm second = LeafForm::kNeedleFan) {
  Random random(7);
  return build_smooth_mesh(
      stages.skeleton, stages.crown, style_with(first, second), random, options);
}

CrownRadii radii_of(const Morphology& tree) {
  if (tree.radii) return *tree.radii;
  const double radius = 0.5 * *tree.cw_m;
  return {radius, radius, radius, radius};
}

void check_promise(const Morphology& tree, const Mesh& mesh) {
  const Measurements measured = measure(mesh);
  const CrownRadii radii = radii_of(tree);
  INFO("h " << tree.h_m << " hcb " << tree.hcb_m << " hc " << tree.hc_m.value_or(-1) << " dbh "
            << tree.dbh_cm << " radii " << radii.east_m << ' ' << radii.west_m << ' '
            << radii.south_m << ' ' << radii.north_m);
  REQUIRE(measured.h_m == Approx(tree.h_m).margin(0.01));
  REQUIRE(measured.hcb_m == Approx(tree.hcb_m).margin(0.01));
  // Floats of places within a meter of the axis, and the section's own arithmetic.
  REQUIRE(measured.dbh_cm == Approx(tree.dbh_cm).epsilon(1e-5));
  REQUIRE(measured.radii.east_m == Approx(radii.east_m).margin(0.01));
  REQUIRE(measured.radii.west_m == Approx(radii.west_m).margin(0.01));
  REQUIRE(measured.radii.south_m == Approx(radii.south_m).margin(0.01));
  REQUIRE(measured.radii.north_m == Approx(radii.north_m).margin(0.01));
}

/// Connected pieces of a part that shares its vertices: the number of each vertex's piece.
std::vector<std::size_t> pieces_of(const MeshPart& part) {
  std::vector<std::size_t> piece(part.vertex_count());
  for (std::size_t i = 0; i < piece.size(); ++i) piece[i] = i;
  const auto root = [&](std::size_t i) {
    while (piece[i] != i) i = piece[i] = piece[piece[i]];
    return i;
  };
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    for (std::size_t j = 1; j < 3; ++j) {
      const std::size_t a = root(part.indices[i]);
      const std::size_t b = root(part.indices[i + j]);
      piece[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < piece.size(); ++i) piece[i] = root(i);
  return piece;
}

std::size_t tubes_of(const MeshPart& part) {
  const std::vector<std::size_t> piece = pieces_of(part);
  std::size_t count = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) count += piece[i] == i ? 1 : 0;
  return count;
}

void check_surfaces(const Mesh& mesh, const Crown& crown, int most_sides) {
  for (const MeshPart& part : mesh.parts) {
    INFO(part_name(part.kind));
    REQUIRE(part.positions.size() == part.normals.size());
    REQUIRE(part.indices.size() % 3 == 0);
    for (const std::uint32_t index : part.indices) REQUIRE(index < part.vertex_count());
    for (std::size_t i = 0; i < part.vertex_count(); ++i) {
      REQUIRE(length(test::normal_of(part, i)) == Approx(1.0).margin(1e-6));
      if (part.kind != PartKind::kStem) REQUIRE(crown.excess_m(test::vertex_of(part, i)) < 0.001);
    }
    REQUIRE(test::least_doubled_area(part) > 0.0);
    if (part.kind == PartKind::kFoliage) {
      REQUIRE(test::turned_triangles(part) == 0);
      continue;
    }
    REQUIRE(test::open_edges(part) == 0);
    REQUIRE(test::volume_m3(part) > 0.0);
    if (part.kind == PartKind::kStem) {
      REQUIRE(test::turned_triangles(part) == 0);
    } else if (part.uvs.empty()) {
      REQUIRE(test::open_or_split_edges(part) == 0);
      // A limb's base shares its corners, and so their normals, with its sides.
      REQUIRE(test::turned_triangles(part) <=
              tubes_of(part) * static_cast<std::size_t>(most_sides - 2));
    }
  }
}

/// How many closed surfaces a place is inside of: the sum of the solid angles of their triangles as
/// seen from it (van Oosterom and Strackee 1983), over that of the sphere.
template <typename Counts>
double winding(const Mesh& mesh, Point place, Counts counts) {
  double sum = 0.0;
  for (const MeshPart& part : mesh.parts) {
    if (part.kind == PartKind::kFoliage) continue;
    for (std::size_t i = 0; i < part.triangle_count(); ++i) {
      if (!counts(part, part.indices[3 * i])) continue;
      const auto [p, q, r] = test::triangle_of(part, i);
      const Point a = p - place;
      const Point b = q - place;
      const Point c = r - place;
      const double la = length(a);
      const double lb = length(b);
      const double lc = length(c);
      sum += 2.0 * std::atan2(dot(a, cross(b, c)),
                              la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
  }
  return sum / (4.0 * std::numbers::pi);
}

/// Corners of limbs' bases that no other tube has inside it.
std::size_t bases_outside(const Mesh& mesh) {
  constexpr double kSeen = 0.001;  // m
  const MeshPart& branches = mesh.parts[1];
  REQUIRE(branches.kind == PartKind::kBranches);
  const std::vector<std::size_t> piece = pieces_of(branches);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    // A tube's vertices begin with its base; the polygon's first three corners stand for it.
    if (piece[i] != i) continue;
    // Where the crown curve pinches a tube to nothing, what begins on it is nothing, too.
    const double side = length(test::vertex_of(branches, i) - test::vertex_of(branches, i + 1));
    if (side < kSeen) continue;
    for (std::size_t corner = i; corner < i + 3; ++corner) {
      const double inside = winding(
          mesh, test::vertex_of(branches, corner), [&](const MeshPart& part, std::size_t v) {
            return part.kind == PartKind::kStem || piece[v] != piece[i];
          });
      if (inside < 0.5) ++outside;
    }
  }
  return outside;
}

}  // namespace

TEST_CASE("any legal tree has its measurements on the smooth mesh") {
  Random random(31);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 25; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      INFO(preset.name << ' ' << i);
      const test::Stages stages = fitted(tree, preset);
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        INFO("level " << level);
        const Mesh mesh = mesh_of(stages, level_of_detail(level));
        check_promise(tree, mesh);
        check_surfaces(mesh, stages.crown, 6);
      }
      const Mesh cards = mesh_of(stages,
                                 {.textured = true, .vertex_colors = true},
                                 LeafForm::kCard,
                                 LeafForm::kCrossedCards);
      check_promise(tree, cards);
      check_surfaces(cards, stages.crown, 6);
    }
  }
}

TEST_CASE("every limb begins inside the one that bears it") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    INFO(preset.name);
    test::Stages stages = fitted(test::paper_tree_1(), preset);
    for (const int level : {0, 2}) {
      INFO("level " << level);
      CHECK(bases_outside(mesh_of(stages, level_of_detail(level))) == 0);
    }
  }
}
