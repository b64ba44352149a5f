// SPDX-License-Identifier: MIT
#include "silvafit/tree/smooth_mesh.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "mesh/smooth_mesh_limbs.hpp"
#include "mesh/smooth_mesh_rings.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

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
  return {.bark = test::shipped_presets().named("schima-superba").bark,
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

void check_mesh_measurements(const Morphology& tree, const Mesh& mesh) {
  const Measurements measured = measure(mesh);
  test::check_mesh_measurements(tree, measured);
  // Floats of places within a meter of the axis, and the section's own arithmetic.
  REQUIRE(measured.dbh_cm == Approx(tree.dbh_cm).epsilon(1e-5));
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

/// The number of closed surfaces that contain a point: the sum of the solid angles of their
/// triangles as seen from it (van Oosterom and Strackee 1983), divided by that of the sphere.
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

/// Corners of limbs' bases that are not inside another tube.
std::size_t bases_outside(const Mesh& mesh) {
  constexpr double kSeen = 0.001;  // m
  const MeshPart& branches = mesh.parts[1];
  REQUIRE(branches.kind == PartKind::kBranches);
  const std::vector<std::size_t> piece = pieces_of(branches);
  std::size_t outside = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    // A tube's vertices begin with its base; the polygon's first three corners represent it.
    if (piece[i] != i) continue;
    // If the crown curve reduces a tube to a point, the limbs that begin on it are points, too.
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

TEST_CASE("the smooth mesh of any valid tree has its measurements") {
  Random random(31);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 25; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      INFO(preset.name << ' ' << i);
      const test::Stages stages = fitted(tree, preset);
      for (int level = 0; level < kLevelsOfDetail; ++level) {
        INFO("level " << level);
        const Mesh mesh = mesh_of(stages, level_of_detail(level));
        check_mesh_measurements(tree, mesh);
        check_surfaces(mesh, stages.crown, 6);
      }
      const Mesh cards =
          mesh_of(stages, {.textured = true}, LeafForm::kCard, LeafForm::kCrossedCards);
      check_mesh_measurements(tree, cards);
      check_surfaces(cards, stages.crown, 6);
    }
  }
}

TEST_CASE("every limb begins inside its parent") {
  for (const Preset& preset : test::shipped_presets().presets()) {
    INFO(preset.name);
    test::Stages stages = fitted(test::paper_tree_1(), preset);
    for (const int level : {0, 2}) {
      INFO("level " << level);
      CHECK(bases_outside(mesh_of(stages, level_of_detail(level))) == 0);
    }
  }
}

TEST_CASE("each level of detail of a smooth mesh is coarser and within its stated error") {
  Random random(35);
  for (const Preset& preset : test::shipped_presets().presets()) {
    for (int i = 0; i < 2; ++i) {
      const Morphology tree = i == 0 ? test::paper_tree_1() : test::random_morphology(random, i);
      const test::Stages stages = fitted(tree, preset);
      const Mesh finest = mesh_of(stages);
      CHECK(finest.surface_error_m == 0.0);
      std::size_t triangles = finest.triangle_count();
      for (int level = 1; level < kLevelsOfDetail; ++level) {
        const Mesh coarse = mesh_of(stages, level_of_detail(level));
        const double stated = coarse.surface_error_m;
        const double measured =
            std::max(test::farthest_wood_m(finest, coarse), test::farthest_wood_m(coarse, finest));
        INFO(preset.name << " level " << level << " stated " << stated << " measured " << measured);
        // The finest level's steps themselves; rings that the crown curve makes smaller.
        CHECK(measured <= stated + 0.0005);
        if (i == 0) CHECK(measured >= 0.25 * stated);
        CHECK(coarse.triangle_count() < triangles);
        triangles = coarse.triangle_count();
      }
    }
  }
}

namespace {

/// A stem 6 m high and two limbs, one of which is continued by another axis from its end.
struct HandMade {
  Skeleton skeleton{};
  Crown crown{{.dbh_cm = 12, .h_m = 6, .hcb_m = 2, .hc_m = 3, .radii = {2, 2, 2, 2}}, {2.0, 1.5}};

  HandMade() {
    axis(0,
         0,
         {{{0, 0, 0}, 0.08},
          {{0, 0, 1.3}, 0.06},
          {{0, 0, 2}, 0.055},
          {{0.1, 0, 4}, 0.03},
          {{0, 0, 6}, 0}});
    axis(1, 0, {{{0, 0, 2}, 0.04}, {{0.6, 0, 2.6}, 0.035}, {{1.0, 0, 3.0}, 0.03}});
    axis(1, 0, {{{0.02, 0, 2.8}, 0.02}, {{-1, 0.2, 3.2}, 0.015}, {{-1.6, 0, 3.0}, 0}});
    axis(2, 1, {{{1.0, 0, 3.0}, 0.03}, {{1.2, 0.3, 3.3}, 0.02}, {{1.3, 0.3, 3.6}, 0}});
    axis(2, 1, {{{1.0, 0, 3.0}, 0.012}, {{1.3, -0.3, 3.1}, 0}});
  }

  void axis(std::uint32_t order, std::uint32_t parent, std::vector<SkeletonPoint> points) {
    skeleton.axes.push_back({.order = order,
                             .parent = parent,
                             .first = static_cast<std::uint32_t>(skeleton.points.size()),
                             .count = static_cast<std::uint32_t>(points.size())});
    skeleton.points.insert(skeleton.points.end(), points.begin(), points.end());
  }

  Mesh mesh(const MeshOptions& options = {}, const SmoothStyle& style = {}) const {
    Random random(1);
    return build_smooth_mesh(skeleton, crown, style, random, options);
  }
};

}  // namespace

TEST_CASE("an axis that continues its parent from its end is one tube with it") {
  const HandMade tree;
  const Mesh mesh = tree.mesh();
  // Two limbs and the side twig; the first limb's continuation is part of its tube.
  CHECK(tubes_of(mesh.parts[1]) == 3);
  CHECK(bases_outside(mesh) == 0);
  check_surfaces(mesh, tree.crown, 6);
  // If its order is not drawn, the limb ends in a point where the axis would continue.
  const Mesh bare = tree.mesh({.wood_order = 1});
  CHECK(tubes_of(bare.parts[1]) == 2);
  check_surfaces(bare, tree.crown, 6);
  double nearest = 1.0;
  for (std::size_t i = 0; i < bare.parts[1].vertex_count(); ++i) {
    nearest = std::min(nearest, length(test::vertex_of(bare.parts[1], i) - Point{1.0, 0.0, 3.0}));
  }
  CHECK(nearest < 1e-6);
}

TEST_CASE("rings are at equal steps of a limb's curve") {
  const HandMade tree;
  const Limbs limbs(tree.skeleton);
  CurveSampler sampler;
  std::vector<Ring> samples;
  Limb limb = limbs.all()[2];
  limb.collar_m = 0.0;
  sampler.sample(limbs.pieces_of(limb), limb, 0.002, samples);
  REQUIRE(samples.size() > 12);
  const double step = samples.back().along_m / static_cast<double>(samples.size() - 1);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    CHECK(samples[i].along_m - samples[i - 1].along_m == Approx(step).epsilon(1e-9));
    // A chord is shorter than its arc by the 24th part of the turn's square.
    const double turn = std::acos(dot(samples[i].tangent, samples[i - 1].tangent));
    const double chord = step * (1.0 - turn * turn / 24.0);
    CHECK(length(samples[i].at - samples[i - 1].at) == Approx(chord).epsilon(1e-3));
    CHECK(dot(samples[i].sideways, samples[i].tangent) == Approx(0.0).margin(1e-12));
    CHECK(length(cross(samples[i].tangent, samples[i].sideways) - samples[i].upward) < 1e-12);
  }
  // Half the tolerance needs sqrt(2) times as many steps.
  std::vector<Ring> finer;
  sampler.sample(limbs.pieces_of(limb), limb, 0.001, finer);
  CHECK(static_cast<double>(finer.size()) ==
        Approx(std::sqrt(2.0) * static_cast<double>(samples.size())).epsilon(0.05));
}

TEST_CASE("limbs have the volume of the round ones that they represent") {
  // A straight cone, alone on a thin stem, far inside its crown.
  Skeleton skeleton;
  skeleton.points = {{{0, 0, 0}, 0.02},
                     {{0, 0, 1.3}, 0.02},
                     {{0, 0, 10}, 0.0},
                     {{0, 0, 3}, 0.1},
                     {{1, 0, 4}, 0.075},
                     {{4, 0, 7}, 0.0}};
  skeleton.axes = {{0, 0, 0, 3}, {1, 0, 3, 3}};
  const Crown crown({.dbh_cm = 4, .h_m = 10, .hcb_m = 0, .hc_m = 5, .radii = {20, 20, 20, 20}},
                    {1, 1});
  for (const int sides : {3, 6, 17}) {
    Random random(1);
    const Mesh mesh = build_smooth_mesh(skeleton, crown, {}, random, {.branch_sides = sides});
    REQUIRE(mesh.parts.size() == 2);
    const double whole = std::numbers::pi * 0.01 * 4.0 * std::sqrt(2.0) / 3.0;
    // The base is thinner up to its collar, to fit into the stem: at most half a diameter's length
    // of the cone is lacking, less what the bend away from the stem adds.
    const double lacking = std::numbers::pi * 0.01 * 0.1;
    const double volume = test::volume_m3(mesh.parts[1]);
    CHECK(volume < whole);
    CHECK(volume > whole - 2.0 * lacking);
  }
}

TEST_CASE("a leaf in five polygons has its outline and meets at its petiole") {
  HandMade tree;
  tree.skeleton.leaves.push_back(
      {.at = {1.0, 0, 3.0}, .along = {0, 0, 1}, .facing = {1, 0, 0}, .length_m = 0.2, .axis = 1});
  SmoothStyle style{.leaves = {{.aspect = 0.5,
                                .outline = {{0.5, 0.1}, {1.0, 0.4}, {0.6, 0.7}},
                                .color = {0.1, 0.4, 0.1}}}};
  const Mesh mesh = tree.mesh({}, style);
  REQUIRE(mesh.parts.size() == 3);
  const MeshPart& leaf = mesh.parts[2];
  CHECK(leaf.double_sided);
  // The petiole's end, three points a side, the tip; the fan of the five polygons: the one with the
  // tip takes two triangles, the other four one each.
  CHECK(leaf.vertex_count() == 8);
  CHECK(leaf.triangle_count() == 6);
  double area = 0.0;
  for (std::size_t i = 0; i < leaf.triangle_count(); ++i) {
    const auto [a, b, c] = test::triangle_of(leaf, i);
    CHECK(length(a - test::vertex_of(leaf, 0)) == 0.0);
    // In the leaf's plane, seen from its upper side.
    area += 0.5 * dot(cross(b - a, c - a), {1, 0, 0});
  }
  // The shoelace formula: half width 0.05, length 0.2.
  const double half = 0.5 * (0.5 * 0.4 - 1.0 * 0.1 + 1.0 * 0.7 - 0.6 * 0.4 + 0.6 * 1.0);
  CHECK(area == Approx(2.0 * half * 0.05 * 0.2).epsilon(1e-5));
  const Point tip = test::vertex_of(leaf, 4) - test::vertex_of(leaf, 0);
  CHECK(tip.z == Approx(0.2).epsilon(1e-5));
  CHECK(leaf.colors.empty());
  CHECK(leaf.uvs.empty());
}

TEST_CASE("cards have their part of a picture, and are drawn as leaves without it") {
  HandMade tree;
  tree.skeleton.leaves.push_back(
      {.at = {1.0, 0, 3.0}, .along = {0, 0, 1}, .facing = {1, 0, 0}, .length_m = 0.2, .axis = 1});
  const auto texture = std::make_shared<const Texture>(
      Texture{.name = "leaf", .width = 1, .height = 1, .rgba = {9, 9, 9, 255}});
  SmoothStyle style{.bark = test::shipped_presets().named("schima-superba").bark,
                    .leaves = {{.form = LeafForm::kCrossedCards,
                                .aspect = 0.5,
                                .color = {1, 1, 1},
                                .texture = texture,
                                .picture = {0.25, 0.5, 0.5, 1.0}}}};
  const Mesh mesh = tree.mesh({.textured = true}, style);
  const MeshPart& leaf = mesh.parts[2];
  CHECK(leaf.texture == texture);
  CHECK(mesh.parts[0].texture == style.bark.picture->color());
  CHECK(leaf.triangle_count() == 4);
  REQUIRE(leaf.uvs.size() == 16);
  for (std::size_t i = 0; i < 8; ++i) {
    // The base is the lower edge of the picture, the origin its upper left corner.
    const bool is_base = std::abs(test::vertex_of(leaf, i).z - test::vertex_of(leaf, 0).z) < 1e-6;
    CHECK(leaf.uvs[2 * i + 1] == (is_base ? 1.0F : 0.5F));
    CHECK((leaf.uvs[2 * i] == 0.25F || leaf.uvs[2 * i] == 0.5F));
  }
  const auto normal_of = [&](std::size_t triangle) {
    const auto [a, b, c] = test::triangle_of(leaf, triangle);
    return direction(cross(b - a, c - a));
  };
  CHECK(std::abs(dot(normal_of(0), normal_of(2))) < 1e-5);
  const Mesh bare = tree.mesh({}, style);
  CHECK(bare.parts[2].triangle_count() == 6);
  CHECK(bare.parts[2].texture == nullptr);
  CHECK(bare.parts[0].texture == nullptr);
}

TEST_CASE("thinned foliage keeps every n-th leaf, enlarged, whatever the seed") {
  const test::Stages stages =
      fitted(test::paper_tree_1(), test::shipped_presets().named("schima-superba"));
  const auto leafy = [&](const MeshOptions& options) {
    return mesh_of(stages, options, LeafForm::kFivePolygons, LeafForm::kFivePolygons);
  };
  const Mesh all = leafy({});
  const Mesh some = leafy({.foliage_per = 4});
  const std::size_t leaves = all.parts[2].vertex_count() / 8;
  CHECK(leaves == stages.skeleton.leaves.size());
  CHECK(some.parts[2].vertex_count() / 8 == (leaves + 3) / 4);
  CHECK(all.parts[2].positions == leafy({}).parts[2].positions);
}

TEST_CASE("invalid input for a smooth mesh is refused with the reason") {
  HandMade tree;
  tree.skeleton.leaves.push_back({.at = {1.0, 0, 3.0},
                                  .along = {0, 0, 1},
                                  .facing = {1, 0, 0},
                                  .length_m = 0.2,
                                  .axis = 1,
                                  .grade = 2});
  CHECK_THROWS_AS(tree.mesh(), UsageError);
  tree.skeleton.leaves[0].grade = 0;
  CHECK_THROWS_AS(tree.mesh({}, {.leaves = {{.outline = {{1, 0.5}}}}}), UsageError);
  const auto texture = std::make_shared<const Texture>();
  CHECK_THROWS_AS(tree.mesh({}, {.leaves = {{}, {.texture = texture}}}), UsageError);
  CHECK_THROWS_AS(tree.mesh({.stem_sides = 2}, {.leaves = {{}}}), UsageError);
  tree.skeleton.points[4].at.x = NAN;
  CHECK_THROWS_AS(tree.mesh({}, {.leaves = {{}}}), GeometryError);
}
