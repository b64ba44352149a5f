// SPDX-License-Identifier: MIT
#include "light.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "degree.hpp"

namespace silvafit::render {
namespace {

using Eigen::Vector3f;

constexpr float kPi = std::numbers::pi_v<float>;
/// Maximum number of reflections; further ones add nothing visible.
constexpr int kMostReflections = 2;

float uniform(Random& random) { return static_cast<float>(random.uniform()); }

/// Two directions orthogonal to a third and to each other.
std::array<Vector3f, 2> frame_of(const Vector3f& axis) {
  const Vector3f helper = std::abs(axis.x()) < 0.7F ? Vector3f::UnitX() : Vector3f::UnitY();
  const Vector3f first = axis.cross(helper).normalized();
  return {first, axis.cross(first)};
}

/// A direction around a normal, with probability proportional to its cosine.
Vector3f cosine_direction(const Vector3f& normal, Random& random) {
  const float radius = std::sqrt(uniform(random));
  const float angle = 2.0F * kPi * uniform(random);
  const auto [first, second] = frame_of(normal);
  const float upright = std::sqrt(std::max(0.0F, 1.0F - radius * radius));
  return (radius * std::cos(angle) * first + radius * std::sin(angle) * second + upright * normal)
      .normalized();
}

/// A direction within the sun's disk, half a degree wide.
Vector3f sun_direction(const Vector3f& middle, Random& random) {
  constexpr float kSunRadius = 0.00465F;
  const float radius = kSunRadius * std::sqrt(uniform(random));
  const float angle = 2.0F * kPi * uniform(random);
  const auto [first, second] = frame_of(middle);
  return (middle + radius * std::cos(angle) * first + radius * std::sin(angle) * second)
      .normalized();
}

/// A ray that starts on the side of the surface to which it goes.
Ray leaving(const Hit& hit, const Vector3f& flat_normal, const Vector3f& direction) {
  // Rounding of single precision at the point and at the distance of the ray.
  const float size = std::max({1.0F, hit.at.cwiseAbs().maxCoeff(), hit.distance});
  const float offset = 2e-6F * size;
  const float side = flat_normal.dot(direction) < 0.0F ? -1.0F : 1.0F;
  return {hit.at + side * offset * flat_normal, direction};
}

Vector3f mixed(const Vector3f& a, const Vector3f& b, float share) { return a + share * (b - a); }

}  // namespace

Vector3f sky_direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = kDegree * azimuth_deg;
  const double elevation = kDegree * elevation_deg;
  return Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                         std::sin(elevation),
                         -std::cos(azimuth) * std::cos(elevation))
      .cast<float>();
}

Light::Light(const TracedScene& scene, SunPosition sun, float ground_m)
    : scene_(scene),
      to_sun_(sky_direction(sun.azimuth_deg, sun.elevation_deg)),
      ground_m_(ground_m),
      ground_{.color = {0.22, 0.20, 0.13}} {
  // A low sun is red and weak, and the sky darkens with it.
  const float height = to_sun_.y();
  const float day = std::clamp((height + 0.1F) / 0.3F, 0.02F, 1.0F);
  const float warmth = std::clamp(1.0F - height / 0.5F, 0.0F, 1.0F);
  sun_color_ =
      height > 0.0F
          ? Vector3f(
                mixed(Vector3f(2.9F, 2.7F, 2.4F), Vector3f(2.4F, 1.3F, 0.6F), warmth * warmth) *
                std::min(1.0F, 0.3F + 2.0F * height))
          : Vector3f::Zero();
  zenith_ = day * Vector3f(0.20F, 0.38F, 0.75F);
  horizon_ =
      day * mixed(Vector3f(0.72F, 0.82F, 0.92F), Vector3f(0.95F, 0.72F, 0.50F), 0.6F * warmth);
  scale_m_ = (scene.bounds()[1] - scene.bounds()[0]).norm();
}

Vector3f Light::sky(const Vector3f& direction) const {
  const float height = std::max(0.0F, direction.y());
  return mixed(horizon_, zenith_, std::sqrt(height));
}

std::optional<Hit> Light::first_hit(const Ray& ray) const {
  std::optional<Hit> hit = scene_.nearest(ray);
  if (!std::isfinite(ground_m_) || ray.direction.y() >= 0.0F) return hit;
  const float distance = (ground_m_ - ray.origin.y()) / ray.direction.y();
  if (distance <= 0.0F || (hit && hit->distance <= distance)) return hit;
  return Hit{.distance = distance,
             .at = ray.origin + distance * ray.direction,
             .color = Vector3f(static_cast<float>(ground_.color[0]),
                               static_cast<float>(ground_.color[1]),
                               static_cast<float>(ground_.color[2])),
             .material = &ground_};
}

Vector3f Light::from_sun(const Hit& hit,
                         const Vector3f& normal,
                         const Vector3f& flat_normal,
                         Random& random) const {
  const Vector3f direction = sun_direction(to_sun_, random);
  const float cosine = normal.dot(direction);
  const float share = cosine >= 0.0F ? 1.0F : static_cast<float>(hit.material->translucency);
  // If the smooth normal faces the sun but the triangle does not, the surface shades itself.
  const bool is_behind = flat_normal.dot(direction) < 0.0F;
  if (is_behind && hit.material->translucency <= 0.0) return Vector3f::Zero();
  if (share <= 0.0F || sun_color_.isZero()) return Vector3f::Zero();
  if (scene_.is_blocked(leaving(hit, flat_normal, direction))) return Vector3f::Zero();
  return share * std::abs(cosine) * sun_color_;
}

Vector3f Light::from_sky(const Hit& hit,
                         const Vector3f& normal,
                         const Vector3f& flat_normal,
                         Random& random) const {
  const auto through = static_cast<float>(hit.material->translucency);
  const bool is_from_behind = uniform(random) * (1.0F + through) > 1.0F;
  const Vector3f direction = cosine_direction(is_from_behind ? Vector3f(-normal) : normal, random);
  // Other surfaces give a little light where the sky is blocked.
  constexpr float kBounced = 0.12F;
  const Vector3f arriving = direction.y() < 0.0F ? Vector3f(kBounced * horizon_)
                            : scene_.is_blocked(leaving(hit, flat_normal, direction))
                                ? Vector3f(kBounced * horizon_)
                                : sky(direction);
  return (1.0F + through) * arriving;
}

Vector3f Light::scattered(const Hit& hit,
                          const Vector3f& normal,
                          const Vector3f& flat_normal,
                          Random& random) const {
  const Vector3f light =
      from_sun(hit, normal, flat_normal, random) + from_sky(hit, normal, flat_normal, random);
  return hit.color.cwiseProduct(light);
}

Vector3f Light::along(const Ray& ray, Random& random, int depth) const {
  const std::optional<Hit> hit = first_hit(ray);
  if (!hit) return sky(ray.direction);
  const bool is_back = hit->flat_normal.dot(ray.direction) > 0.0F;
  const Vector3f flat_normal = is_back ? Vector3f(-hit->flat_normal) : hit->flat_normal;
  // Vertex normals of a leaf may point to its other side.
  const Vector3f normal =
      hit->normal.dot(flat_normal) < 0.0F ? Vector3f(-hit->normal) : hit->normal;
  const auto reflectance = static_cast<float>(hit->material->reflectance);
  if (reflectance > 0.0F && depth < kMostReflections) {
    const float cosine = std::clamp(-normal.dot(ray.direction), 0.0F, 1.0F);
    const float share = reflectance + (1.0F - reflectance) * std::pow(1.0F - cosine, 5.0F);
    if (uniform(random) < share) {
      const Vector3f direction =
          (ray.direction - 2.0F * normal.dot(ray.direction) * normal).normalized();
      return along(leaving(*hit, flat_normal, direction), random, depth + 1);
    }
  }
  Vector3f light = scattered(*hit, normal, flat_normal, random);
  if (hit->material != &ground_) return light;
  // The plane is infinite: it fades into the horizon.
  const float haze =
      1.0F - std::exp(-std::max(0.0F, hit->distance - 2.0F * scale_m_) / (4.0F * scale_m_));
  return mixed(light, horizon_, haze);
}

}  // namespace silvafit::render
