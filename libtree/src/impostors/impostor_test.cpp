// SPDX-License-Identifier: MIT
#include "silvafit/tree/impostor.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "impostors/crown_pictures.hpp"
#include "silvafit/base/error.hpp"
#include "test_support/measurement_test_support.hpp"
#include "test_support/mesh_test_support.hpp"
#include "test_support/tree_test_support.hpp"

using namespace silvafit;
using namespace silvafit::tree;

namespace {

std::vector<const Builder*> all_presets() {
  std::vector<const Builder*> presets;
  for (const BuilderKind kind : all_values<BuilderKind>()) {
    for (const Builder* builder : test::shipped_builders().of(kind)) presets.push_back(builder);
  }
  return presets;
}

GrowOptions far_away(Impostors& impostors) {
  return {.mesh = level_of_detail(kLevelsOfDetail - 1), .impostors = &impostors};
}

/// A square picture of opacities in [0, 1].
struct Opacities {
  std::size_t side = 0;
  std::vector<double> values{};

  explicit Opacities(const Texture& texture) : side(texture.width) {
    for (std::size_t i = 3; i < texture.rgba.size(); i += 4) {
      values.push_back(texture.rgba[i] / 255.0);
    }
  }

  double at(std::size_t x, std::size_t y) const { return values[y * side + x]; }

  /// As viewers make mipmaps: each pixel is the mean of four.
  Opacities halved() const {
    Opacities half = *this;
    half.side /= 2;
    half.values.clear();
    for (std::size_t y = 0; y < side; y += 2) {
      for (std::size_t x = 0; x < side; x += 2) {
        half.values.push_back(0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)));
      }
    }
    return half;
  }

  /// Of the pictures from the sides, which fill three quarters of the atlas.
  double opaque_share() const {
    const auto opaque =
        std::ranges::count_if(values, [](double opacity) { return opacity >= 0.5; });
    return static_cast<double>(opaque) / static_cast<double>(values.size());
  }

  bool has_opaque(std::size_t left, std::size_t top, std::size_t width, std::size_t height) const {
    for (std::size_t y = top; y < top + height; ++y) {
      for (std::size_t x = left; x < left + width; ++x) {
        if (at(x, y) >= 0.5) return true;
      }
    }
    return false;
  }
};

}  // namespace

TEST_CASE("impostors have the measurements of any valid tree") {
  Random random(61);
  Impostors impostors;
  for (const Builder* builder : all_presets()) {
    for (int i = 0; i < 8; ++i) {
      const Morphology tree = test::random_morphology(random, i);
      const SceneTree grown = grow_tree(tree, *builder, far_away(impostors));
      test::check_mesh_measurements(tree, grown);
      for (const MeshPart& part : grown.mesh.parts) {
        INFO(builder->name() << ' ' << part_name(part.kind));
        REQUIRE(test::turned_triangles(part) == 0);
        REQUIRE(test::least_doubled_area(part) > 0.0);
        for (std::size_t v = 0; v < part.vertex_count(); ++v) {
          REQUIRE(length(test::normal_of(part, v)) == Approx(1.0).margin(1e-6));
        }
      }
      REQUIRE(test::open_edges(grown.mesh.parts.front()) == 0);
      // Four cards of at most four quads on both sides, the roof, and a stem of at most ten
      // sections of four sides.
      REQUIRE(grown.measured.triangles <= 64 + 8 + 90);
    }
  }
}

TEST_CASE("the picture of a crown has the extent of the crown") {
  // The pictures of the outermost shoots have transparent edges of some centimeters.
  constexpr std::size_t kEdge = 8;
  constexpr std::size_t kCell = 128;
  constexpr std::size_t kBorder = 4;
  constexpr std::size_t kCrown = kCell - 2 * kBorder;
  for (const Builder* builder : all_presets()) {
    const Opacities atlas(
        *draw_crown(*builder, {.width = 5, .slenderness = 1}, Season::kSummer).texture);
    REQUIRE(atlas.side == 2 * kCell);
    for (const std::size_t cell : {0, 1, 2}) {
      const std::size_t left = cell % 2 * kCell + kBorder;
      const std::size_t top = cell / 2 * kCell + kBorder;
      INFO(builder->name() << " picture " << cell);
      CHECK(atlas.has_opaque(left, top, kCrown, kEdge));
      CHECK(atlas.has_opaque(left, top + kCrown - kEdge, kCrown, kEdge));
      // The diagonal directions have no measured radii.
      if (cell == 2) continue;
      CHECK(atlas.has_opaque(left, top, kEdge, kCrown));
      CHECK(atlas.has_opaque(left + kCrown - kEdge, top, kEdge, kCrown));
    }
  }
}

TEST_CASE("crowns in mipmaps have about as many gaps as the picture") {
  double sum = 0.0;
  int number = 0;
  for (const Builder* builder : all_presets()) {
    if (builder->name().starts_with("honda")) continue;  // nearly without leaves
    Opacities atlas(*draw_crown(*builder, {.width = 5, .slenderness = 1}, Season::kSummer).texture);
    const double whole = atlas.opaque_share();
    for (int level = 1; level <= 3; ++level) {
      atlas = atlas.halved();
      INFO(builder->name() << " level " << level);
      CHECK(atlas.opaque_share() == Approx(whole).epsilon(0.3));
      sum += atlas.opaque_share() / whole;
      ++number;
    }
  }
  CHECK(sum / number == Approx(1.0).margin(0.1));
}

TEST_CASE("an impostor depends on its tree only") {
  const Builder& builder = test::shipped_builders().named(BuilderKind::kSegment, "schima-superba");
  const Morphology tree = test::paper_tree_1();
  Morphology other = tree;
  other.cw_m = 9.0;
  other.radii.reset();
  Impostors first;
  Impostors second;
  static_cast<void>(grow_tree(other, builder, far_away(second)));
  const Mesh alone = grow_tree(tree, builder, far_away(first)).mesh;
  const Mesh later = grow_tree(tree, builder, far_away(second)).mesh;
  for (std::size_t i = 0; i < alone.parts.size(); ++i) {
    CHECK(alone.parts[i].positions == later.parts[i].positions);
    CHECK(alone.parts[i].uvs == later.parts[i].uvs);
  }
  CHECK(alone.parts.back().texture->rgba == later.parts.back().texture->rgba);
  CHECK(alone.parts.back().texture->name == later.parts.back().texture->name);
}

TEST_CASE("impostors show whole and fitted crowns only") {
  const Builder& builder = test::shipped_builders().named(BuilderKind::kLsystem, "honda-7a");
  Impostors impostors;
  GrowOptions options = far_away(impostors);
  const TreeOverlap overlap;
  CHECK_THROWS_AS(grow_tree(test::paper_tree_1(), builder, options, &overlap), UsageError);
  options.is_unfitted = true;
  CHECK_THROWS_AS(grow_tree(test::paper_tree_1(), builder, options), UsageError);
}
