// SPDX-License-Identifier: MIT
#include "light.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "noise.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::render {
namespace {

using Eigen::Vector3f;

constexpr float kPi = std::numbers::pi_v<float>;
/// After this number of surfaces a path may end at random; the second number is the maximum.
constexpr int kCertainSurfaces = 2;
constexpr int kMostSurfaces = 32;

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

/// Schlick's reflectance; a rough surface has less of it at grazing angles (Lagarde).
float fresnel(const Material& material, float cosine) {
  const auto least = static_cast<float>(material.reflectance);
  const float most = std::max(1.0F - static_cast<float>(material.roughness), least);
  return least + (most - least) * std::pow(1.0F - std::clamp(cosine, 0.0F, 1.0F), 5.0F);
}

/// The share of the microfacets that are visible from a direction (Smith, GGX).
float visible_share(float cosine, float alpha) {
  const float square = alpha * alpha;
  return 2.0F * cosine / (cosine + std::sqrt(square + (1.0F - square) * cosine * cosine));
}

/// The density of microfacets with a normal at this cosine from the surface's (GGX).
float facet_density(float cosine, float alpha) {
  const float square = alpha * alpha;
  const float base = cosine * cosine * (square - 1.0F) + 1.0F;
  return square / (kPi * base * base);
}

/// The normal of a microfacet that is visible from a direction, drawn by their visible areas
/// (Heitz 2018, Sampling the GGX distribution of visible normals, JCGT 7).
Vector3f visible_facet(const Vector3f& normal, const Vector3f& to, float alpha, Random& random) {
  const auto [x, y] = frame_of(normal);
  const Vector3f own(to.dot(x), to.dot(y), to.dot(normal));
  const Vector3f view = Vector3f(alpha * own.x(), alpha * own.y(), own.z()).normalized();
  const auto [first, second] = frame_of(view);
  const float radius = std::sqrt(uniform(random));
  const float angle = 2.0F * kPi * uniform(random);
  const float a = radius * std::cos(angle);
  const float share = 0.5F * (1.0F + view.z());
  // frame_of() need not be oriented to the surface: the second coordinate is the one that tilts.
  const Vector3f level =
      view.z() < 0.9999F ? Vector3f(-view.y(), view.x(), 0.0F).normalized() : Vector3f(first);
  const Vector3f tilted = view.z() < 0.9999F ? Vector3f(view.cross(level)) : Vector3f(second);
  const float b =
      (1.0F - share) * std::sqrt(std::max(0.0F, 1.0F - a * a)) + share * radius * std::sin(angle);
  const Vector3f facet =
      a * level + b * tilted + std::sqrt(std::max(0.0F, 1.0F - a * a - b * b)) * view;
  const Vector3f stretched =
      Vector3f(alpha * facet.x(), alpha * facet.y(), std::max(1e-6F, facet.z())).normalized();
  return stretched.x() * x + stretched.y() * y + stretched.z() * normal;
}

float alpha_of(const Material& material) {
  const auto roughness = static_cast<float>(material.roughness);
  return roughness * roughness;
}

}  // namespace

/// A surface as it is seen along a ray: both normals are on the side of the ray.
struct Surroundings {
  const Hit& hit;
  Vector3f back;  ///< towards the start of the ray
  Vector3f flat_normal;
  Vector3f normal;
  Vector3f facet_normal;    ///< of what reflects: not smooth, but with the relief of the normal map
  float reflected = 0.0F;   ///< share of the light that is reflected
  float through = 0.0F;     ///< light scattered to the other side relative to this side
  Vector3f color{0, 0, 0};  ///< scattered to this side; both sides together at most 1

  Surroundings(const Hit& at, const Ray& ray) : hit(at), back(-ray.direction) {
    flat_normal = at.flat_normal.dot(back) < 0.0F ? Vector3f(-at.flat_normal) : at.flat_normal;
    // Vertex normals of a leaf may point to its other side.
    normal = at.normal.dot(flat_normal) < 0.0F ? Vector3f(-at.normal) : at.normal;
    facet_normal =
        at.facet_normal.dot(flat_normal) < 0.0F ? Vector3f(-at.facet_normal) : at.facet_normal;
    if (facet_normal.dot(back) <= 0.0F) facet_normal = flat_normal;
    if (at.material->reflectance > 0.0) reflected = fresnel(*at.material, facet_normal.dot(back));
    through = static_cast<float>(at.material->translucency);
    color = at.color / std::max(1.0F, (1.0F + through) * at.color.maxCoeff());
  }
};

Vector3f sky_direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = kRadian * azimuth_deg;
  const double elevation = kRadian * elevation_deg;
  return Eigen::Vector3d(std::sin(azimuth) * std::cos(elevation),
                         std::sin(elevation),
                         -std::cos(azimuth) * std::cos(elevation))
      .cast<float>();
}

Sky sky_with(const SunPosition& sun, bool has_clouds) {
  Sky sky{.to_sun = sky_direction(sun.azimuth_deg, sun.elevation_deg), .has_clouds = has_clouds};
  const float height = sky.to_sun.y();
  const float day = std::clamp((height + 0.1F) / 0.3F, 0.02F, 1.0F);
  const float warmth = std::clamp(1.0F - height / 0.5F, 0.0F, 1.0F);
  if (height > 0.0F) {
    const Vector3f high(2.9F, 2.7F, 2.4F);
    const Vector3f low(2.4F, 1.3F, 0.6F);
    sky.sun = mixed(high, low, warmth * warmth) * std::min(1.0F, 0.3F + 2.0F * height);
  }
  sky.zenith = day * Vector3f(0.20F, 0.38F, 0.75F);
  sky.horizon =
      day * mixed(Vector3f(0.72F, 0.82F, 0.92F), Vector3f(0.95F, 0.72F, 0.50F), 0.6F * warmth);
  return sky;
}

Vector3f Sky::along(const Vector3f& direction) const {
  const float height = std::max(0.0F, direction.y());
  const Vector3f clear = mixed(horizon, zenith, std::sqrt(height));
  if (!has_clouds) return clear;
  // Clouds lie in a plane, flattened towards the horizon, where haze hides them.
  constexpr float kNearestHorizon = 0.08F;
  const float flat = 1.6F / (height + kNearestHorizon);
  const float density = fractal_noise(flat * direction.x(), flat * direction.z(), 6);
  const float cover = std::clamp((density - 0.5F) / 0.18F, 0.0F, 1.0F) *
                      std::clamp((height - 0.02F) / 0.2F, 0.0F, 1.0F);
  const float towards_sun = std::max(0.0F, direction.dot(to_sun));
  // White where they are thin or near the sun, grey where they are thick.
  const Vector3f cloud =
      (1.15F - 0.45F * std::clamp((density - 0.55F) / 0.25F, 0.0F, 1.0F)) * horizon +
      0.25F * std::pow(towards_sun, 8.0F) * sun;
  const Vector3f glow = 0.35F * std::pow(towards_sun, 40.0F) * sun;
  return mixed(clear + glow, cloud, 0.9F * cover);
}

Light::Light(const TracedScene& scene, const Sky& sky, float ground_m)
    : scene_(scene), sky_(sky), ground_m_(ground_m), ground_{.color = {0.22, 0.20, 0.13}} {
  scale_m_ = (scene.bounds()[1] - scene.bounds()[0]).norm();
}

/// The floor of a forest has light and dark, green and brown patches.
std::optional<Hit> Light::first_hit(const Ray& ray) const {
  std::optional<Hit> hit = first_surface(ray);
  if (!hit || !hit->is_ground || !sky_.has_clouds) return hit;
  const float large = fractal_noise(0.35F * hit->at.x(), 0.35F * hit->at.z(), 4);
  const float small = fractal_noise(9.0F * hit->at.x() + 50.0F, 9.0F * hit->at.z(), 4);
  const Vector3f brown(0.13F, 0.095F, 0.06F);
  const Vector3f green(0.10F, 0.12F, 0.05F);
  const float share = std::clamp(2.5F * (large - 0.4F), 0.0F, 1.0F);
  hit->color = (0.45F + 1.1F * small) * mixed(brown, green, share);
  return hit;
}

std::optional<Hit> Light::first_surface(const Ray& ray) const {
  std::optional<Hit> hit = scene_.nearest(ray);
  if (!std::isfinite(ground_m_) || ray.direction.y() >= 0.0F) return hit;
  const float distance = (ground_m_ - ray.origin.y()) / ray.direction.y();
  if (distance <= 0.0F || (hit && hit->distance <= distance)) return hit;
  return Hit{.distance = distance,
             .at = ray.origin + distance * ray.direction,
             .color = Vector3f(static_cast<float>(ground_.color[0]),
                               static_cast<float>(ground_.color[1]),
                               static_cast<float>(ground_.color[2])),
             .material = &ground_,
             .is_ground = true};
}

/// The sun's light that a surface scatters and reflects back along the ray.
Vector3f Light::from_sun(const Surroundings& here, Random& random) const {
  if (sky_.sun.isZero()) return Vector3f::Zero();
  const Vector3f direction = sun_direction(sky_.to_sun, random);
  // If the smooth normal faces the sun but the triangle does not, the surface shades itself.
  const float flat_cosine = here.flat_normal.dot(direction);
  if (flat_cosine < 0.0F && here.through <= 0.0F) return Vector3f::Zero();
  const float cosine = here.normal.dot(direction);
  const float share = cosine >= 0.0F ? 1.0F : here.through;
  Vector3f light = (1.0F - here.reflected) * share * std::abs(cosine) * here.color;
  const float alpha = alpha_of(*here.hit.material);
  const float facet_cosine = here.facet_normal.dot(direction);
  if (here.reflected > 0.0F && alpha > 0.0F && flat_cosine > 0.0F && facet_cosine > 0.0F) {
    const Vector3f facet = (direction + here.back).normalized();
    const float view_cosine = std::max(here.facet_normal.dot(here.back), 1e-4F);
    const float density = facet_density(here.facet_normal.dot(facet), alpha);
    const float reflected = here.reflected * density * visible_share(facet_cosine, alpha) *
                            visible_share(view_cosine, alpha) / (4.0F * view_cosine);
    light += Vector3f::Constant(kPi * reflected);
  }
  if (light.isZero() || scene_.is_blocked(leaving(here.hit, here.flat_normal, direction))) {
    return Vector3f::Zero();
  }
  return light.cwiseProduct(sky_.sun);
}

/// The next direction of the path, and the share of its light that returns along the ray.
Ray Light::next(const Surroundings& here, Random& random, Vector3f& share) const {
  if (here.reflected > 0.0F && uniform(random) < here.reflected) {
    const float alpha = alpha_of(*here.hit.material);
    // A mirror reflects by its smooth normal, a rough surface by that of its triangle and relief.
    const Vector3f facet =
        alpha > 0.0F ? visible_facet(here.facet_normal, here.back, alpha, random) : here.normal;
    const Vector3f direction = (2.0F * facet.dot(here.back) * facet - here.back).normalized();
    const float cosine = here.facet_normal.dot(direction);
    const bool is_away = cosine > 0.0F && here.flat_normal.dot(direction) > 0.0F;
    if (alpha > 0.0F) share *= is_away ? visible_share(cosine, alpha) : 0.0F;
    return leaving(here.hit, here.flat_normal, direction);
  }
  const bool is_through = uniform(random) * (1.0F + here.through) > 1.0F;
  Vector3f direction = cosine_direction(is_through ? Vector3f(-here.normal) : here.normal, random);
  const float cosine = here.flat_normal.dot(direction);
  // A smooth normal must not send light through an opaque surface.
  if (cosine < 0.0F && here.through <= 0.0F) direction -= 2.0F * cosine * here.flat_normal;
  share = share.cwiseProduct((1.0F + here.through) * here.color);
  return leaving(here.hit, here.flat_normal, direction);
}

Vector3f Light::along(Ray ray, Random& random, bool& is_free) const {
  is_free = false;
  Vector3f sum = Vector3f::Zero();
  Vector3f share = Vector3f::Ones();
  for (int surfaces = 0; surfaces < kMostSurfaces; ++surfaces) {
    const std::optional<Hit> hit = first_hit(ray);
    is_free = !hit && surfaces == 0;
    if (!hit) return sum + share.cwiseProduct(sky_.along(ray.direction));
    if (surfaces == 0 && hit->material == &ground_) {
      // The plane is infinite: it fades into the horizon.
      const float haze =
          1.0F - std::exp(-std::max(0.0F, hit->distance - 2.0F * scale_m_) / (4.0F * scale_m_));
      sum += haze * sky_.horizon;
      share *= 1.0F - haze;
    }
    const Surroundings here(*hit, ray);
    sum += share.cwiseProduct(from_sun(here, random));
    ray = next(here, random, share);
    if (surfaces + 1 < kCertainSurfaces) continue;
    const float chance = std::min(share.maxCoeff(), 1.0F);
    if (!(uniform(random) < chance)) break;
    share /= chance;
  }
  return sum;
}

}  // namespace silvafit::render
