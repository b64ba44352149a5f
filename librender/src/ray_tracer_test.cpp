// SPDX-License-Identifier: MIT
#include "silvafit/render/ray_tracer.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "texture_sampling.hpp"

using namespace silvafit;
using namespace silvafit::render;

namespace {

/// A level square of side 2 about a place, seen from above.
Surface plate(double x, double y, double z, const Material& material) {
  const auto f = [](double value) { return static_cast<float>(value); };
  return {.material = material,
          .positions = {f(x - 1),
                        f(y),
                        f(z - 1),
                        f(x - 1),
                        f(y),
                        f(z + 1),
                        f(x + 1),
                        f(y),
                        f(z + 1),
                        f(x + 1),
                        f(y),
                        f(z - 1)},
          .indices = {0, 1, 2, 0, 2, 3}};
}

Scene scene_of(std::vector<Surface> surfaces) {
  return {.models = {{.surfaces = std::move(surfaces)}}, .instances = {{}}};
}

RenderOptions small() { return {.width = 64, .height = 64, .samples = 16, .threads = 1}; }

double brightness(const Picture& picture, std::size_t x, std::size_t y) {
  const std::uint8_t* pixel = picture.pixel(x, y);
  return pixel[0] + pixel[1] + pixel[2];
}

/// From straight above (but for a degree), upwards in the picture being north.
Camera from_above() { return {.azimuth_deg = 180.0, .elevation_deg = 89.0, .view_deg = 10.0}; }

}  // namespace

TEST_CASE("pixels depend on neither the number of threads nor the run") {
  const RayTracer tracer(scene_of({plate(0, 1, 0, {}), plate(0.5, 2, 0.5, {.translucency = 0.4})}));
  RenderOptions options = small();
  const Picture one = tracer.picture(options);
  options.threads = 3;
  CHECK(tracer.picture(options).rgb == one.rgb);
  options.seed = 2;
  CHECK(tracer.picture(options).rgb != one.rgb);
}

TEST_CASE("the shadow of a plate has the direction and length of the sun's position") {
  // The plate hangs 4 m over a large level floor; sun in the west at 45 degrees: the shadow lies
  // 4 m to the east. The floor's bounds are the picture's.
  Surface floor = plate(0, 0, 0, {.color = {0.5, 0.5, 0.5}});
  for (float& value : floor.positions) value *= 8.0F;
  const RayTracer tracer(scene_of({floor, plate(0, 4, 0, {.color = {1, 1, 1}})}));
  RenderOptions options = small();
  options.camera = from_above();
  options.sun = {.azimuth_deg = 270.0, .elevation_deg = 45.0};
  options.has_ground = false;
  const Picture picture = tracer.picture(options);
  // 64 pixels show about 17 m; the middle is the stem of the plate.
  const auto column = [](double east_m) {
    return static_cast<std::size_t>(std::lround(32.0 + east_m * 64.0 / 17.4));
  };
  // Only the sky lights the shadow; after tone mapping that is well below three quarters.
  CHECK(brightness(picture, column(4.0), 32) < 0.75 * brightness(picture, column(-4.0), 32));
  CHECK(brightness(picture, column(6.5), 32) > 0.9 * brightness(picture, column(-6.5), 32));
  CHECK(brightness(picture, column(2.2), 32) > 0.9 * brightness(picture, column(-2.2), 32));
}

TEST_CASE("a transparent picture is opaque where the scene is, by its share of each pixel") {
  RenderOptions options = small();
  options.camera = from_above();
  options.has_ground = false;
  options.is_transparent = true;
  const RayTracer tracer(scene_of({plate(0, 0, 0, {.color = {0.5, 0.5, 0.5}})}));
  const Picture picture = tracer.picture(options);
  REQUIRE(picture.opacity.size() == 64 * 64);
  CHECK(picture.opacity[32 * 64 + 32] == 255);
  CHECK(picture.opacity[0] == 0);
  // The square fills the picture but for the margin of 6 %; its edges cross pixels.
  double sum = 0.0;
  for (const std::uint8_t opacity : picture.opacity) sum += opacity / 255.0;
  CHECK(sum / (64.0 * 64.0) == Approx(1.0 / (1.06 * 1.06)).epsilon(0.01));
  // The plate has its color without the sky's, also at its edges.
  options.is_transparent = false;
  const Picture opaque = tracer.picture(options);
  CHECK(opaque.opacity.empty());
  CHECK(brightness(picture, 32, 32) == brightness(opaque, 32, 32));
  const std::vector<Picture> both{picture, picture};
  CHECK(contact_sheet(both, 2).opacity.size() == 64 * (64 + 4 + 64));
  CHECK_THROWS_AS(contact_sheet({picture, opaque}, 2), silvafit::UsageError);
}

TEST_CASE("light from behind passes a leaf, but not a board") {
  RenderOptions options = small();
  options.camera = {.azimuth_deg = 180.0, .elevation_deg = -60.0, .view_deg = 20.0};
  options.sun = {.azimuth_deg = 180.0, .elevation_deg = 80.0};
  options.has_ground = false;
  const Material board{.color = {0.3, 0.5, 0.1}, .double_sided = true};
  Material leaf = board;
  leaf.translucency = 0.6;
  const double dark =
      brightness(RayTracer(scene_of({plate(0, 3, 0, board)})).picture(options), 32, 32);
  const double bright =
      brightness(RayTracer(scene_of({plate(0, 3, 0, leaf)})).picture(options), 32, 32);
  // Tone mapping compresses the ratio; both are also lit by the horizon from below.
  CHECK(bright > 1.3 * dark);
}

TEST_CASE("rays pass where a picture is transparent, and shadows have its shape") {
  // A plate 4 m over a floor whose picture is opaque on its western half only; sun in the west at
  // 45 degrees: that half's shadow lies 3 to 4 m to the east, and light falls on the rest.
  Surface floor = plate(0, 0, 0, {.color = {0.5, 0.5, 0.5}});
  for (float& value : floor.positions) value *= 8.0F;
  Surface card = plate(0, 4, 0, {.color = {1, 1, 1}, .double_sided = true});
  // West is left in the picture, north above.
  card.uvs = {0, 0, 0, 1, 1, 1, 1, 0};
  auto texture = std::make_shared<tree::Texture>(tree::Texture{.width = 64, .height = 64});
  for (int i = 0; i < 64 * 64; ++i) {
    const bool is_west = i % 64 < 32;
    texture->rgba.insert(texture->rgba.end(),
                         {255, 0, 0, static_cast<std::uint8_t>(is_west ? 255 : 0)});
  }
  card.texture = texture;
  const RayTracer tracer(scene_of({floor, card}));
  RenderOptions options = small();
  options.camera = from_above();
  options.sun = {.azimuth_deg = 270.0, .elevation_deg = 45.0};
  options.has_ground = false;
  const Picture picture = tracer.picture(options);
  const auto column = [](double east_m) {
    return static_cast<std::size_t>(std::lround(32.0 + east_m * 64.0 / 17.4));
  };
  CHECK(brightness(picture, column(3.5), 32) < 0.75 * brightness(picture, column(-4.0), 32));
  CHECK(brightness(picture, column(4.6), 32) > 0.9 * brightness(picture, column(-4.0), 32));
  // The opaque half is red; through the other one the floor is gray.
  const std::uint8_t* west = picture.pixel(column(-0.5), 32);
  const std::uint8_t* east = picture.pixel(column(0.5), 32);
  CHECK(west[0] > 100);
  CHECK(west[1] < 20);
  CHECK(east[1] > 100);
}

TEST_CASE("the back of a picture with one side is not drawn") {
  // A wall that faces south, half of which is transparent: as in glTF, a viewer in the north sees
  // through the other half, too, unless both sides are to be drawn.
  auto texture = std::make_shared<tree::Texture>(tree::Texture{.width = 2, .height = 1});
  texture->rgba = {230, 5, 5, 255, 230, 5, 5, 0};
  const auto shown_red = [&](bool double_sided, double azimuth) {
    Surface wall = plate(0, 0, 0, {.double_sided = double_sided});
    wall.positions = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    wall.uvs = {0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F};
    wall.texture = texture;
    RenderOptions options = small();
    options.camera = {.azimuth_deg = azimuth, .elevation_deg = 0.0};
    options.has_ground = false;
    const Picture picture = RayTracer(scene_of({wall})).picture(options);
    const std::uint8_t* middle = picture.pixel(32, 32);
    return middle[0] > 2 * middle[2];
  };
  CHECK(shown_red(false, 180.0));
  CHECK_FALSE(shown_red(false, 0.0));
  CHECK(shown_red(true, 0.0));
}

TEST_CASE("colors between pixels are mixed in linear light and by opacity") {
  // A black and a white pixel; between them, and over the edge, half of the light.
  const tree::Texture pair{.width = 2, .height = 1, .rgba = {0, 0, 0, 255, 255, 255, 255, 255}};
  CHECK(sampled(pair, 0.25F, 0.5F)[0] == Approx(0.0F).margin(1e-6));
  CHECK(sampled(pair, 0.75F, 0.5F)[0] == Approx(1.0F).margin(1e-6));
  CHECK(sampled(pair, 0.5F, 0.5F)[0] == Approx(0.5F).margin(1e-6));
  CHECK(sampled(pair, 0.0F, 0.5F)[0] == Approx(0.5F).margin(1e-6));
  CHECK(sampled(pair, 1.75F, -3.5F)[0] == Approx(1.0F).margin(1e-6));
  CHECK(sampled(pair, -0.75F, 0.5F)[0] == Approx(0.0F).margin(1e-6));
  // Transparent pixels do not contribute color.
  const tree::Texture edge{.width = 2, .height = 1, .rgba = {0, 255, 0, 0, 255, 0, 0, 255}};
  const Eigen::Vector4f mixed = sampled(edge, 0.5F, 0.5F);
  CHECK(mixed[0] == Approx(1.0F).margin(1e-6));
  CHECK(mixed[1] == Approx(0.0F).margin(1e-6));
  CHECK(mixed[3] == Approx(0.5F).margin(1e-6));
  CHECK(opacity(edge, 0.5F, 0.5F) == Approx(0.5F).margin(1e-6));
}

TEST_CASE("a mirror shows what is above it") {
  // A perfect mirror below a red plate, seen from above at an angle: by the law of reflection the
  // ray that meets the mirror's middle 45 degrees from the south meets the plate 4 m to the north
  // at 4 m height.
  Scene scene = scene_of({plate(0, 0, 0, {.reflectance = 1.0}),
                          plate(0, 4, -4, {.color = {0.9, 0.02, 0.02}, .double_sided = true})});
  RenderOptions options = small();
  options.camera = {.azimuth_deg = 180.0,
                    .elevation_deg = 45.0,
                    .view_deg = 10.0,
                    .zoom = 1.0,
                    .target = Vector{0, 0, 0}};
  options.has_ground = false;
  const Picture picture = RayTracer(scene).picture(options);
  const std::uint8_t* middle = picture.pixel(32, 32);
  CHECK(middle[0] > 2 * middle[2]);
  scene.models[0].surfaces.pop_back();
  const Picture sky = RayTracer(scene).picture(options);
  CHECK(sky.pixel(32, 32)[2] >= sky.pixel(32, 32)[0]);
}

TEST_CASE("a scene fills the image, and stays in it") {
  // A red wall before white sky and a margin of 6 percent: it reaches both edges of the direction
  // that decides, and none in a picture a little larger.
  for (const auto& [wide, tall] : {std::pair{2.0F, 0.5F}, std::pair{0.5F, 3.0F}}) {
    Surface wall = plate(0, 0, 0, {.color = {0.9, 0.02, 0.02}, .double_sided = true});
    wall.positions = {-wide, -tall, 1, wide, -tall, 1, wide, tall, -1, -wide, tall, -1};
    const RayTracer tracer(scene_of({wall}));
    for (const double azimuth : {180.0, 200.0}) {
      RenderOptions options = small();
      options.camera = {.azimuth_deg = azimuth, .elevation_deg = 25.0, .view_deg = 40.0};
      options.has_ground = false;
      const Picture picture = tracer.picture(options);
      std::array<std::size_t, 4> box{64, 0, 64, 0};
      for (std::size_t y = 0; y < 64; ++y) {
        for (std::size_t x = 0; x < 64; ++x) {
          const std::uint8_t* pixel = picture.pixel(x, y);
          if (pixel[0] < pixel[2] + 20) continue;
          box = {
              std::min(box[0], x), std::max(box[1], x), std::min(box[2], y), std::max(box[3], y)};
        }
      }
      // 1.06 of the outline is the image: 1.8 of 64 pixels at each side, to a pixel.
      const std::size_t nearest = std::min({box[0], 63 - box[1], box[2], 63 - box[3]});
      INFO("left " << box[0] << ", right " << box[1] << ", top " << box[2] << ", bottom "
                   << box[3]);
      CHECK(nearest >= 1);
      CHECK(nearest <= 3);
      // The remaining space is equal on both sides.
      CHECK(std::abs(static_cast<int>(box[0] + box[1]) - 63) <= 2);
      CHECK(std::abs(static_cast<int>(box[2] + box[3]) - 63) <= 2);
    }
  }
}

TEST_CASE("the camera's target is the middle of the image") {
  RenderOptions options = small();
  options.camera = {.azimuth_deg = 180.0, .elevation_deg = 60.0, .target = Vector{3, 2, 0}};
  options.has_ground = false;
  const RayTracer tracer(
      scene_of({plate(3, 2, 0, {.color = {0.9, 0.02, 0.02}}), plate(-8, 0, 0, {})}));
  const auto picture = tracer.picture(options);
  const std::uint8_t* middle = picture.pixel(32, 32);
  CHECK(middle[0] > 2 * middle[2]);
}

TEST_CASE("a normal map turns the light of a surface") {
  // Flat, seen from above with the sun in the east at 45 degrees: a map whose normal leans 45
  // degrees east faces the sun, one that leans west gets none of it.
  const auto shown = [](double x) {
    Surface flat = plate(0, 0, 0, {.color = {0.1, 0.1, 0.1}});
    flat.uvs = {0, 0, 0, 1, 1, 1, 1, 0};
    auto map = std::make_shared<tree::Texture>(tree::Texture{.width = 1, .height = 1});
    const auto byte = [](double value) {
      return static_cast<std::uint8_t>(std::lround(127.5 + 127.5 * value));
    };
    map->rgba = {byte(x), byte(0.0), byte(std::sqrt(1.0 - x * x)), 255};
    flat.normal_texture = map;
    RenderOptions options = small();
    options.camera = from_above();
    options.sun = {.azimuth_deg = 90.0, .elevation_deg = 45.0};
    options.has_ground = false;
    return brightness(RayTracer(scene_of({flat})).picture(options), 32, 32);
  };
  const double half = std::sqrt(0.5);
  CHECK(shown(half) > 1.1 * shown(0.0));
  CHECK(shown(0.0) > 1.3 * shown(-half));
}

TEST_CASE("instances are models at given positions") {
  const Scene two{
      .models = {{.surfaces = {plate(0, 1, 0, {})}}},
      .instances = {{},
                    {.model = 0, .transform = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 10, 5, 0, 1}}}};
  const RayTracer tracer(two);
  CHECK(tracer.triangle_count() == 4);
  const auto bounds = tracer.bounds();
  CHECK(bounds[0] == Vector{-1, 1, -2});
  CHECK(bounds[1] == Vector{12, 6, 2});
}

TEST_CASE("invalid scenes and options are refused") {
  CHECK_THROWS_AS(RayTracer(Scene{}), UsageError);
  Scene scene = scene_of({plate(0, 1, 0, {})});
  scene.instances[0].model = 3;
  CHECK_THROWS_AS(RayTracer(scene), UsageError);
  scene = scene_of({plate(0, 1, 0, {})});
  scene.models[0].surfaces[0].indices[2] = 9;
  CHECK_THROWS_AS(RayTracer(scene), UsageError);
  const RayTracer tracer(scene_of({plate(0, 1, 0, {})}));
  CHECK_THROWS_AS(tracer.picture({.width = 0}), UsageError);
  CHECK_THROWS_AS(tracer.picture({.width = 8, .height = 8, .camera = {.elevation_deg = 95.0}}),
                  UsageError);
}
