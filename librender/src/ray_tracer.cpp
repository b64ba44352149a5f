// SPDX-License-Identifier: MIT
#include "silvafit/render/ray_tracer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "light.hpp"
#include "silvafit/base/constants.hpp"
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
  const auto is_finite = [](double value) { return std::isfinite(value); };
  if (camera.target && !std::ranges::all_of(*camera.target, is_finite)) {
    throw UsageError("the camera's target must be finite");
  }
  if (camera.standpoint) {
    const Standpoint& from = *camera.standpoint;
    if (!std::ranges::all_of(from.eye, is_finite) || !std::isfinite(from.azimuth_deg) ||
        !(std::abs(from.elevation_deg) <= 89.0)) {
      throw UsageError(
          "the place of the eye must be finite, and the elevation of the view between -89 and 89 "
          "degrees");
    }
  }
  if (!(camera.zoom > 0.0) || !std::isfinite(camera.zoom)) {
    throw UsageError("the zoom must be positive");
  }
  if (!std::isfinite(options.sun.azimuth_deg) || !(std::abs(options.sun.elevation_deg) <= 90.0)) {
    throw UsageError("the sun's elevation must be between -90 and 90 degrees");
  }
}

Vector3f vector_of(const Vector& values) {
  return Eigen::Map<const Eigen::Vector3d>(values.data()).cast<float>();
}

/// Rays through the pixels of an image.
class Lens {
 public:
  /// \param outline  points that are in the image if the zoom is 1
  Lens(const std::vector<Vector3f>& outline, const RenderOptions& options)
      : width_(static_cast<float>(options.width)), height_(static_cast<float>(options.height)) {
    const Camera& camera = options.camera;
    half_height_ = static_cast<float>(std::tan(0.5 * kRadian * camera.view_deg));
    const Vector3f backwards = camera.standpoint
                                   ? Vector3f(-sky_direction(camera.standpoint->azimuth_deg,
                                                             camera.standpoint->elevation_deg))
                                   : sky_direction(camera.azimuth_deg, camera.elevation_deg);
    forward_ = -backwards;
    right_ = forward_.cross(Vector3f::UnitY()).normalized();
    up_ = right_.cross(forward_);
    if (camera.standpoint) {
      eye_ = target_ = vector_of(camera.standpoint->eye);
      require_near(outline);
      return;
    }
    if (camera.target) {
      aim_at(vector_of(*camera.target), outline);
    } else {
      frame(outline);
    }
    eye_ = target_ + distance_ / static_cast<float>(camera.zoom) * backwards;
    require_near(outline);
  }

  /// \param x, y  from the upper left corner, in pixels
  Ray ray(float x, float y) const {
    const float across = (2.0F * x - width_) / height_ * half_height_;
    const float upright = (height_ - 2.0F * y) / height_ * half_height_;
    return {eye_, (forward_ + across * right_ + upright * up_).normalized()};
  }

 private:
  static constexpr float kMargin = 1.06F;

  /// Rays are computed with 24 bits: from a distance of a million times its size, the scene has 16
  /// places; farther away coordinates overflow.
  void require_near(const std::vector<Vector3f>& outline) const {
    constexpr double kMostSizes = 1e6;
    const Eigen::Vector3d center = outline.front().cast<double>();
    double size = std::numeric_limits<float>::min();
    for (const Vector3f& point : outline) {
      size = std::max(size, (point.cast<double>() - center).norm());
    }
    const auto is_near = [&](const Vector3f& point) {
      return (point.cast<double>() - center).norm() <= kMostSizes * size;
    };
    if (is_near(eye_) && is_near(target_)) return;
    throw UsageError(
        "the camera, or its target, is more than a million times the size of the scene away from "
        "it; choose a target in the scene (`target`) and a larger `zoom`");
  }

  /// Tangents of the largest angles to the side and up, less the margin.
  float wide() const { return half_height_ * width_ / height_ / kMargin; }
  float tall() const { return half_height_ / kMargin; }

  /// The distance at which everything is in the image around a target.
  void aim_at(const Vector3f& target, const std::vector<Vector3f>& outline) {
    target_ = target;
    for (const Vector3f& point : outline) {
      const Vector3f offset = point - target;
      const float needed =
          std::max(std::abs(offset.dot(right_)) / wide(), std::abs(offset.dot(up_)) / tall());
      distance_ = std::max(distance_, needed - offset.dot(forward_));
    }
    distance_ = std::max(distance_, std::numeric_limits<float>::min());
  }

  /// The nearest camera that has everything in its image. For the sides of the image, whose slope
  /// is s, every point (x, z) with z forward must have |x - eye_x| <= s (z - eye_z): the largest
  /// values of x - s z and of -x - s z are two lines that meet at the eye. The same holds for the
  /// upper and the lower edge; the pair that needs the larger distance decides.
  void frame(const std::vector<Vector3f>& outline) {
    const auto [x, z_wide] = meeting_point(outline, right_, wide());
    const auto [y, z_tall] = meeting_point(outline, up_, tall());
    float nearest = std::numeric_limits<float>::infinity();
    float farthest = -nearest;
    for (const Vector3f& point : outline) {
      nearest = std::min(nearest, point.dot(forward_));
      farthest = std::max(farthest, point.dot(forward_));
    }
    const float eye = std::min({z_wide, z_tall, nearest});
    const float middle = 0.5F * (nearest + farthest);
    distance_ = std::max(middle - eye, std::numeric_limits<float>::min());
    // In the direction with extra space the outline is in the middle of the image.
    target_ = centered(outline, right_, eye, x) * right_ + centered(outline, up_, eye, y) * up_ +
              middle * forward_;
  }

  std::array<float, 2> meeting_point(const std::vector<Vector3f>& outline,
                                     const Vector3f& side,
                                     float slope) const {
    float upper = -std::numeric_limits<float>::infinity();
    float lower = upper;
    for (const Vector3f& point : outline) {
      const float behind = slope * point.dot(forward_);
      upper = std::max(upper, point.dot(side) - behind);
      lower = std::max(lower, -point.dot(side) - behind);
    }
    return {0.5F * (upper - lower), -0.5F * (upper + lower) / slope};
  }

  /// The place of the eye along a side from which the largest angles to both sides are equal,
  /// starting from a guess.
  float centered(const std::vector<Vector3f>& outline,
                 const Vector3f& side,
                 float eye,
                 float guess) const {
    constexpr int kSteps = 8;
    for (int i = 0; i < kSteps; ++i) {
      float most = -std::numeric_limits<float>::infinity();
      float least = -most;
      float depth = 0.0F;
      for (const Vector3f& point : outline) {
        const float ahead = std::max(point.dot(forward_) - eye, 1e-6F);
        most = std::max(most, (point.dot(side) - guess) / ahead);
        least = std::min(least, (point.dot(side) - guess) / ahead);
        depth = std::max(depth, ahead);
      }
      guess += 0.5F * (most + least) * std::min(distance_, depth);
    }
    return guess;
  }

  float width_;
  float height_;
  float half_height_ = 1.0F;
  float distance_ = 0.0F;  ///< of the eye from the target if the zoom is 1
  Vector3f target_{0, 0, 0};
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

struct Pixel {
  Vector3f light{0, 0, 0};
  float opacity = 1.0F;
};

Pixel pixel_at(const Light& light,
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
  std::size_t drawn = 0;
  for (std::size_t i = 0; i < options.samples; ++i) {
    shift_x += kStepX;
    shift_y += kStepY;
    shift_x -= std::floor(shift_x);
    shift_y -= std::floor(shift_y);
    const Ray ray = lens.ray(static_cast<float>(static_cast<double>(x) + shift_x),
                             static_cast<float>(static_cast<double>(y) + shift_y));
    // A single reflection must not make its pixel too bright.
    constexpr float kBrightest = 8.0F;
    bool is_free = false;
    const Vector3f arrived = light.along(ray, random, is_free).cwiseMin(kBrightest);
    if (is_free && options.is_transparent) continue;
    sum += arrived;
    ++drawn;
  }
  if (drawn == 0) return {.opacity = 0.0F};
  return {.light = sum / static_cast<float>(drawn),
          .opacity = static_cast<float>(drawn) / static_cast<float>(options.samples)};
}

/// Within a forest a hundredth of the light arrives. As a camera does, the image is brightened
/// until the mean of its logarithms is a middle grey. Source: Reinhard et al. 2002, Photographic
/// tone reproduction for digital images, equation 1.
float exposure_of(const std::vector<Pixel>& pixels) {
  constexpr float kMiddleGrey = 0.18F;
  // Black pixels have no logarithm.
  constexpr float kBlack = 1e-3F;
  // More would show the noise of the darkest parts.
  constexpr float kMost = 8.0F;
  double sum = 0.0;
  for (const Pixel& one : pixels) {
    sum += std::log(kBlack + one.light.dot(Vector3f(0.2126F, 0.7152F, 0.0722F)));
  }
  const auto mean = static_cast<float>(std::exp(sum / static_cast<double>(pixels.size())));
  return std::clamp(kMiddleGrey / mean, 1.0F, kMost);
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
  const Light light(traced, sky_with(options.sun, options.camera.standpoint.has_value()), ground);
  const Lens lens(traced.outline(), options);
  Picture picture{.width = options.width, .height = options.height};
  picture.rgb.resize(3 * options.width * options.height);
  std::vector<Pixel> pixels(options.width * options.height);
  std::atomic<std::size_t> done{0};
  parallel_for(options.height, options.threads, [&](std::size_t y) {
    for (std::size_t x = 0; x < options.width; ++x) {
      pixels[y * options.width + x] = pixel_at(light, lens, x, y, options);
    }
    const std::size_t count = ++done;
    if (options.progress) options.progress(count, options.height);
  });
  const float exposure = options.camera.standpoint ? exposure_of(pixels) : 1.0F;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      picture.rgb[3 * i + k] = to_byte(exposure * pixels[i].light[static_cast<Eigen::Index>(k)]);
    }
    if (!options.is_transparent) continue;
    picture.opacity.push_back(static_cast<std::uint8_t>(std::lround(255.0F * pixels[i].opacity)));
  }
  return picture;
}

}  // namespace silvafit::render
