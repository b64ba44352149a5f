// SPDX-License-Identifier: MIT
// Light of sun and sky, and its paths from surface to surface.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "silvafit/base/random.hpp"
#include "traced_scene.hpp"

namespace silvafit::render {

struct Surroundings;

/// The light of a scene, linear RGB. The color of the sky changes from horizon to zenith.
struct Sky {
  Eigen::Vector3f to_sun{0, 1, 0};  ///< of length 1
  /// Radiance of a white surface that faces the sun: its irradiance by pi.
  Eigen::Vector3f sun{0, 0, 0};
  Eigen::Vector3f zenith{0, 0, 0};
  Eigen::Vector3f horizon{0, 0, 0};
  bool has_clouds = false;

  Eigen::Vector3f along(const Eigen::Vector3f& direction) const;
};

/// The lower the sun, the redder and weaker its light, and the darker the sky.
Sky sky_with(const SunPosition& sun, bool has_clouds = false);

/// Traces paths of light backwards: at each surface, the light of the sun is added and the path
/// continues in one random direction.
///
/// A surface reflects the share F of the light by its rough reflection (GGX, with Schlick's F for
/// the triangle's own normal) and scatters the rest: by its color to the side of the light, and by
/// color times translucency to the other side. Both together never exceed the light that arrives.
class Light {
 public:
  /// \param ground_m  height of the ground plane; not finite without one
  Light(const TracedScene& scene, const Sky& sky, float ground_m);

  /// Light that arrives along a ray, linear RGB.
  /// \param is_free  gets whether the ray meets nothing but the sky
  Eigen::Vector3f along(Ray ray, Random& random, bool& is_free) const;

 private:
  std::optional<Hit> first_hit(const Ray& ray) const;
  std::optional<Hit> first_surface(const Ray& ray) const;
  Eigen::Vector3f from_sun(const Surroundings& here, Random& random) const;
  Ray next(const Surroundings& here, Random& random, Eigen::Vector3f& share) const;

  const TracedScene& scene_;
  Sky sky_;
  float ground_m_;
  Material ground_;
  float scale_m_;  ///< of the scene, by which distance fades the ground into the horizon
};

/// Direction to the sky at an azimuth (clockwise from north) and elevation; x east, y up, z south.
Eigen::Vector3f sky_direction(double azimuth_deg, double elevation_deg);

}  // namespace silvafit::render
