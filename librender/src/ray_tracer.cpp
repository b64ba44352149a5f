// SPDX-License-Identifier: MIT
#include "silvafit/render/ray_tracer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "degree.hpp"
#include "light.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "traced_scene.hpp"

namespace silvafit::render {
namespace {

using Eigen::Vector3f;

constexpr std::size_t kLargestSide = 16384;

void check(const RenderOptions& options) {
  const auto is_side = [](std::size_t side) { return side >= 1 && side <= kLargestSide; };
  if (!is_side(options.width) || !is_side(options.height)) {
    throw UsageError("the width and height of an image must be 1 to 16384 pixels");
  }
  constexpr std::size_t kMostSamples = 65536;
  if (options.samples < 1 || options.samples > kMostSamples) {
    throw UsageError("the number of rays per pixel must be 1 to 65536");
  }
  const Camera& camera = options.camera;
  if (!(camera.view_deg > 1.0 && camera.view_deg < 120.0)) {
    throw UsageError("the field of view must be between 1 and 120 degrees");
  }
  if (!(std::abs(camera.elevation_deg) <= 89.0) || !std::isfinite(camera.azimuth_deg)) {
    throw UsageError("the camera's elevation must be between -89 and 89 degrees");
  }
  if (!(camera.zoom > 0.0) || !std::isfinite(camera.zoom)) {
    throw UsageError("the zoom must be positive");
  }
  if (!std::isfinite(options.sun.azimuth_deg) || !(std::abs(options.sun.elevation_deg) <= 90.0)) {
    throw UsageError("the sun's elevation must be between -90 and 90 degrees");
  }
}

/// Rays through the pixels of an image.
class Lens {
 public:
  Lens(const std::array<Vector3f, 2>& bounds, const RenderOptions& options)
      : width_(static_cast<float>(options.width)), height_(static_cast<float>(options.height)) {
    const Camera& camera = options.camera;
    Vector3f target = 0.5F * (bounds[0] + bounds[1]);
    if (camera.target) {
      target = Eigen::Map<const Eigen::Vector3d>(camera.target->data()).cast<float>();
    }
    half_height_ = static_cast<float>(std::tan(0.5 * kDegree * camera.view_deg));
    const Vector3f backwards = sky_direction(camera.azimuth_deg, camera.elevation_deg);
    forward_ = -backwards;
    right_ = forward_.cross(Vector3f::UnitY()).normalized();
    up_ = right_.cross(forward_);
    eye_ = target + static_cast<float>(distance(bounds, target) / camera.zoom) * backwards;
  }

  /// \param x, y  from the upper left corner, in pixels
  Ray ray(float x, float y) const {
    const float across = (2.0F * x - width_) / height_ * half_height_;
    const float upright = (height_ - 2.0F * y) / height_ * half_height_;
    return {eye_, (forward_ + across * right_ + upright * up_).normalized()};
  }

 private:
  /// A distance at which all corners of the box are in the image, with a margin.
  float distance(const std::array<Vector3f, 2>& bounds, const Vector3f& target) const {
    constexpr float kMargin = 1.06F;
    float result = 0.0F;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3f point(
          bounds[corner & 1].x(), bounds[corner >> 1 & 1].y(), bounds[corner >> 2 & 1].z());
      const Vector3f offset = point - target;
      const float half_width = half_height_ * width_ / height_;
      const float needed = kMargin * std::max(std::abs(offset.dot(right_)) / half_width,
                                              std::abs(offset.dot(up_)) / half_height_);
      result = std::max(result, needed - offset.dot(forward_));
    }
    return std::max(result, std::numeric_limits<float>::min());
  }

  float width_;
  float height_;
  float half_height_ = 1.0F;
  Vector3f eye_;
  Vector3f forward_;
  Vector3f right_;
  Vector3f up_;
};

/// Tone mapping (Narkowicz's fit of the ACES curve), then sRGB.
std::uint8_t to_byte(float light) {
  const float x = std::max(0.0F, light);
  const float film = std::min(1.0F, x * (2.51F * x + 0.03F) / (x * (2.43F * x + 0.59F) + 0.14F));
  const float encoded =
      film <= 0.0031308F ? 12.92F * film : 1.055F * std::pow(film, 1.0F / 2.4F) - 0.055F;
  return static_cast<std::uint8_t>(std::lround(255.0F * std::clamp(encoded, 0.0F, 1.0F)));
}

Vector3f pixel_light(const Light& light,
                     const Lens& lens,
                     std::size_t x,
                     std::size_t y,
                     const RenderOptions& options) {
  Random random(options.seed, y * options.width + x);
  // Points within the pixel by an additive sequence of two irrational steps: uniform for any number
  // of points.
  constexpr double kStepX = 0.7548776662466927;
  constexpr double kStepY = 0.5698402909980532;
  double shift_x = random.uniform();
  double shift_y = random.uniform();
  Vector3f sum = Vector3f::Zero();
  for (std::size_t i = 0; i < options.samples; ++i) {
    shift_x += kStepX;
    shift_y += kStepY;
    shift_x -= std::floor(shift_x);
    shift_y -= std::floor(shift_y);
    const Ray ray = lens.ray(static_cast<float>(static_cast<double>(x) + shift_x),
                             static_cast<float>(static_cast<double>(y) + shift_y));
    // A single reflection must not make its pixel too bright.
    constexpr float kBrightest = 8.0F;
    sum += light.along(ray, random).cwiseMin(kBrightest);
  }
  return sum / static_cast<float>(options.samples);
}

}  // namespace

struct RayTracer::State {
  explicit State(const Scene& scene) : traced(scene) {}
  TracedScene traced;
};

RayTracer::RayTracer(const Scene& scene) : state_(std::make_unique<State>(scene)) {}
RayTracer::~RayTracer() = default;
RayTracer::RayTracer(RayTracer&&) noexcept = default;
RayTracer& RayTracer::operator=(RayTracer&&) noexcept = default;

std::array<Vector, 2> RayTracer::bounds() const {
  std::array<Vector, 2> result{};
  for (std::size_t k = 0; k < 2; ++k) {
    const Vector3f& corner = state_->traced.bounds()[k];
    result[k] = {corner.x(), corner.y(), corner.z()};
  }
  return result;
}

std::size_t RayTracer::triangle_count() const { return state_->traced.triangle_count(); }

Picture RayTracer::picture(const RenderOptions& options) const {
  check(options);
  const TracedScene& traced = state_->traced;
  const float ground =
      options.has_ground ? traced.bounds()[0].y() : std::numeric_limits<float>::quiet_NaN();
  const Light light(traced, options.sun, ground);
  const Lens lens(traced.bounds(), options);
  Picture picture{.width = options.width, .height = options.height};
  picture.rgb.resize(3 * options.width * options.height);
  std::atomic<std::size_t> done{0};
  parallel_for(options.height, options.threads, [&](std::size_t y) {
    for (std::size_t x = 0; x < options.width; ++x) {
      const Vector3f value = pixel_light(light, lens, x, y, options);
      for (int k = 0; k < 3; ++k) picture.pixel(x, y)[k] = to_byte(value[k]);
    }
    const std::size_t count = ++done;
    if (options.progress) options.progress(count, options.height);
  });
  return picture;
}

}  // namespace silvafit::render
