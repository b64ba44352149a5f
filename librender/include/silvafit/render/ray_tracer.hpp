// SPDX-License-Identifier: MIT
// Path tracing of triangle meshes: sun, sky, shadows, light from surface to surface and through
// leaves.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "silvafit/render/picture.hpp"
#include "silvafit/render/sun.hpp"
#include "silvafit/tree/texture.hpp"

namespace silvafit::render {

using Vector = std::array<double, 3>;

/// How a surface scatters light. Colors are linear RGB.
struct Material {
  Vector color{0.6, 0.6, 0.6};
  double translucency = 0.0;  ///< proportion of the light from behind that passes, tinted
  double reflectance = 0.0;   ///< at normal incidence; grows towards 1 at grazing angles (Schlick)
  double roughness = 0.0;     ///< of the reflection: 0 is a mirror, 1 the roughest
  /// False: the back is black, as the inside of a stem; that of a texture with transparent pixels
  /// is not drawn.
  bool double_sided = false;
};

/// Triangles of one material, y up.
struct Surface {
  Material material{};
  std::vector<float> positions{};        ///< 3 per vertex [m]
  std::vector<float> normals{};          ///< 3 per vertex, or none: flat triangles
  std::vector<std::uint8_t> colors{};    ///< 4 per vertex, linear, times the material's; or none
  std::vector<std::uint32_t> indices{};  ///< 3 per triangle
  std::vector<float> uvs{};              ///< 2 per vertex, from the image's upper left; or none
  /// Texture, repeated, and multiplied with the surface's color, or null; rays pass where it is
  /// less than half opaque.
  std::shared_ptr<const tree::Texture> texture{};
  /// Normals relative to the surface, as in glTF, or null.
  std::shared_ptr<const tree::Texture> normal_texture{};
  bool is_ground = false;
};

struct Model {
  std::vector<Surface> surfaces{};
};

/// A placed model: column-major 4 x 4, affine.
struct Instance {
  std::size_t model = 0;
  std::array<double, 16> transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
};

struct Scene {
  std::vector<Model> models{};
  std::vector<Instance> instances{};
};

/// A place from which one looks.
struct Standpoint {
  Vector eye{0.0, 1.7, 0.0};   ///< [x east, y up, z south]
  double azimuth_deg = 0.0;    ///< of the view, clockwise from north
  double elevation_deg = 0.0;  ///< of the view, in [-89, 89]
};

/// By default the scene fills the image: it touches two opposite edges of it, with a margin.
struct Camera {
  double azimuth_deg = 200.0;   ///< azimuth of the camera, clockwise from north
  double elevation_deg = 12.0;  ///< elevation of the camera above the scene's middle, in [-89, 89]
  double view_deg = 35.0;       ///< vertical field of view, in (1, 120)
  double zoom = 1.0;            ///< 2: half the distance
  /// Point in the middle of the image [x east, y up, z south]; default: that of the scene's
  /// outline.
  std::optional<Vector> target{};
  /// Instead of all but the field of view. The ground then reaches to the horizon and has patches,
  /// and the sky has clouds and the sun.
  std::optional<Standpoint> standpoint{};
};

struct RenderOptions {
  std::size_t width = 1280;  ///< 1 to 16384
  std::size_t height = 720;
  std::size_t samples = 16;  ///< rays per pixel
  Camera camera{};
  SunPosition sun{};
  bool has_ground = true;  ///< a plane at the lowest point
  /// The sky is not drawn: pixels are as opaque as the share of their rays that meets the scene.
  bool is_transparent = false;
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one for each core
  /// Called when rows are done, from any thread.
  std::function<void(std::size_t done, std::size_t total)> progress{};
};

/// A scene prepared for images from all directions.
class RayTracer {
 public:
  /// \throws UsageError if an instance has no valid model, sizes of a surface's buffers disagree,
  ///   or the scene is empty; std::bad_alloc or Error if the ray tracing kernel fails
  explicit RayTracer(const Scene& scene);
  ~RayTracer();
  RayTracer(RayTracer&&) noexcept;
  RayTracer& operator=(RayTracer&&) noexcept;

  /// Lowest and highest corner of the scene [m].
  std::array<Vector, 2> bounds() const;
  std::size_t triangle_count() const;  ///< as drawn: those of every instance

  /// The same pixels for the same scene, options and seed, for any number of threads.
  /// \throws UsageError if an option is out of range
  Picture picture(const RenderOptions& options) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace silvafit::render
