// SPDX-License-Identifier: MIT
#include "silvafit/render/forest_floor.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "noise.hpp"
#include "silvafit/base/error.hpp"

using namespace silvafit;
using namespace silvafit::render;

namespace {

/// A ground that rises by a tenth to the east, about the origin, 40 m wide; y is up, z south.
Scene slope() {
  const Surface ground{.positions = {-20, -2, -20, -20, -2, 20, 20, 2, 20, 20, 2, -20},
                       .indices = {0, 1, 2, 0, 2, 3},
                       .is_ground = true};
  return {.models = {{.surfaces = {ground}}}, .instances = {{}}};
}

}  // namespace

TEST_CASE("noise is smooth and fills its range") {
  float least = 1.0F;
  float most = 0.0F;
  for (int k = 0; k < 20000; ++k) {
    const float x = 0.037F * static_cast<float>(k) - 300.0F;
    const float value = value_noise(x, 0.5F * x);
    least = std::min(least, value);
    most = std::max(most, value);
    // Between two corners the cubic's slope is at most 3/2 in each direction.
    CHECK(std::abs(value_noise(x + 1e-3F, 0.5F * x) - value) < 1.6e-3F);
  }
  CHECK(least >= 0.0F);
  CHECK(least < 0.1F);
  CHECK(most <= 1.0F);
  CHECK(most > 0.9F);
}

TEST_CASE("the height of the ground is that below a place, whatever stands there") {
  Scene scene = slope();
  scene.models.push_back(
      {.surfaces = {{.positions = {5, 8, 0, 6, 8, 0, 5, 8, 1}, .indices = {0, 1, 2}}}});
  scene.instances.push_back({.model = 1});
  const GroundHeight ground(scene);
  CHECK(ground.at(5.2, 0.2) == Approx(0.52).margin(1e-5));
  CHECK(ground.at(-10.0, 3.0) == Approx(-1.0).margin(1e-5));
  // Outside, it is the lowest point of the scene.
  CHECK(ground.at(100.0, 0.0) == Approx(-2.0).margin(1e-5));
  CHECK(ground.bounds()[1][1] == Approx(8.0));
}

TEST_CASE("the ground continues from its edges to the horizon") {
  Scene scene = slope();
  extend_ground(scene);
  const GroundHeight ground(scene);
  CHECK(ground.at(10.0, 0.0) == Approx(1.0).margin(1e-5));
  // At its edge it has the height of the edge, and far away that of its middle.
  CHECK(ground.at(20.01, 5.0) == Approx(2.0).margin(0.01));
  CHECK(ground.at(-20.01, 5.0) == Approx(-2.0).margin(0.01));
  CHECK(std::abs(ground.at(3000.0, 100.0)) < 0.5);
  CHECK(std::abs(ground.at(100.0, -3000.0)) < 0.5);
}

TEST_CASE("what grows at a place does not depend on other places") {
  const auto floor_of = [](const std::vector<Vector>& places) {
    Scene scene = slope();
    const GroundHeight ground(scene);
    add_forest_floor(scene, ground, places, 3);
    return scene;
  };
  const Scene one = floor_of({{0, 0, 0}});
  const Scene two = floor_of({{0, 0, 0}, {10, 0, 0}});
  CHECK(one.instances.size() > 3000);
  CHECK(two.instances.size() > one.instances.size());
  const auto is_in_two = [&](const Instance& plant) {
    return std::ranges::any_of(two.instances, [&](const Instance& other) {
      return other.model == plant.model && other.transform == plant.transform;
    });
  };
  for (std::size_t k = 1; k < one.instances.size(); k += 97) {
    const Instance& plant = one.instances[k];
    CHECK(is_in_two(plant));
    const double away = std::hypot(plant.transform[12], plant.transform[14]);
    CHECK(away < 26.0);
    if (std::abs(plant.transform[12]) < 20.0 && std::abs(plant.transform[14]) < 20.0) {
      CHECK(plant.transform[13] == Approx(0.1 * plant.transform[12]).margin(1e-4));
    }
  }
}

TEST_CASE("an eye sees what stands in the direction of its view") {
  // A red board 10 m east of the eye, seen in the middle of a view to the east only.
  Surface board{.material = {.color = {0.8, 0.05, 0.05}, .double_sided = true},
                .positions = {10, 0, -1, 10, 3, -1, 10, 3, 1, 10, 0, 1},
                .indices = {0, 1, 2, 0, 2, 3}};
  const RayTracer tracer(Scene{.models = {{.surfaces = {board}}}, .instances = {{}}});
  RenderOptions options{.width = 33, .height = 33, .samples = 8};
  const auto redness = [&](double azimuth) {
    options.camera.standpoint = Standpoint{.eye = {0.0, 1.7, 0.0}, .azimuth_deg = azimuth};
    const Picture picture = tracer.picture(options);
    const std::uint8_t* pixel = picture.pixel(16, 16);
    return static_cast<double>(pixel[0]) / std::max<int>(1, pixel[2]);
  };
  CHECK(redness(90.0) > 2.0);
  CHECK(redness(270.0) < 1.2);
  options.camera.standpoint = Standpoint{.eye = {0.0, 1.7, 0.0}, .elevation_deg = 95.0};
  CHECK_THROWS_AS(tracer.picture(options), UsageError);
}
