// SPDX-License-Identifier: MIT
// Impostors beside the meshes that they replace.
#include "silvafit/tree/impostor.hpp"

#include <array>
#include <catch2/catch.hpp>

#include "light.hpp"
#include "reference.hpp"
#include "silvafit/render/models.hpp"
#include "silvafit/tree/scene.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "silvafit/tree/scene_writer.hpp"
#include "traced_scene.hpp"

using namespace silvafit;
using namespace silvafit::render;
using Eigen::Vector3f;

namespace {

TracedScene traced_tree(const tree::SceneTree& grown) {
  tree::ReadScene scene;
  tree::ReadModel& model = scene.models.emplace_back();
  for (const tree::ModelPart& part : tree::parts_of(grown.mesh, grown.preset)) {
    model.parts.push_back({part.part, part.material, *part.mesh});
  }
  scene.instances.push_back({.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}});
  return TracedScene(scene_of(scene));
}

/// Area that a tree hides [m2], seen from far away: the mean over directions.
double hidden_area_m2(const TracedScene& scene, double elevation_deg) {
  constexpr int kDirections = 4;
  constexpr float kStep = 0.16F;
  constexpr float kHalf = 12.0F;
  int hidden = 0;
  for (int i = 0; i < kDirections; ++i) {
    const Vector3f towards = sky_direction(180.0 * (i + 0.3) / kDirections, elevation_deg);
    const Vector3f right = Vector3f(-towards.z(), 0.0F, towards.x()).normalized();
    const Vector3f up = right.cross(towards).normalized();
    const Vector3f eye = 0.5F * (scene.bounds()[0] + scene.bounds()[1]) + 100.0F * towards;
    for (float x = -kHalf; x < kHalf; x += kStep) {
      for (float y = -kHalf; y < kHalf; y += kStep) {
        if (scene.is_blocked({eye + x * right + y * up, -towards})) ++hidden;
      }
    }
  }
  return double{kStep} * double{kStep} * hidden / kDirections;
}

/// How much more an impostor hides than the mesh; the mean of several trees.
double area_ratio(const tree::Builder& builder,
                  tree::Impostors& impostors,
                  tree::Morphology morphology,
                  double elevation_deg) {
  constexpr int kTrees = 3;
  double sum = 0.0;
  for (int i = 0; i < kTrees; ++i) {
    morphology.tree = std::to_string(i);
    // The finest mesh, of which the pictures are made. Coarser ones of closed crowns hide less.
    const TracedScene mesh =
        traced_tree(tree::grow_tree(morphology, builder, {.mesh = {.textured = true}}));
    const TracedScene far =
        traced_tree(tree::grow_tree(morphology, builder, {.impostors = &impostors}));
    sum += hidden_area_m2(far, elevation_deg) / hidden_area_m2(mesh, elevation_deg) / kTrees;
  }
  return sum;
}

}  // namespace

TEST_CASE("impostors hide as much as the mesh, in the mean of all directions") {
  const auto catalogue = tree::BuilderCatalogue::load(test::source_file("models"));
  tree::Impostors impostors;
  double sum = 0.0;
  int number = 0;
  for (const tree::BuilderKind kind : all_values<tree::BuilderKind>()) {
    for (const tree::Builder* builder : catalogue.of(kind)) {
      // Figures of a paper, nearly without leaves.
      if (builder->name().starts_with("honda")) continue;
      for (const auto& [h, hcb, cw] : {std::array{16.0, 4.0, 8.0}, std::array{11.0, 3.0, 3.6}}) {
        const tree::Morphology tree{
            .plot = "1", .dbh_cm = 1.5 * h, .h_m = h, .hcb_m = hcb, .cw_m = cw};
        for (const double elevation : {3.0, 25.0}) {
          const double ratio = area_ratio(*builder, impostors, tree, elevation);
          INFO(builder->name() << ", crown of " << cw << " m, from " << elevation << " degrees");
          // Trees share the pictures of a typical one, whose crown differs by up to a sixth in
          // width and length, and has branches of its own.
          CHECK(ratio == Approx(1.0).margin(0.16));
          sum += ratio;
          ++number;
        }
      }
    }
  }
  // In the mean these differences cancel.
  CHECK(sum / number == Approx(1.0).margin(0.03));
}
