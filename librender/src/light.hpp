// SPDX-License-Identifier: MIT
// Light of sun and sky, and its reflection by surfaces.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "silvafit/base/random.hpp"
#include "traced_scene.hpp"

namespace silvafit::render {

class Light {
 public:
  /// \param ground_m  height of the ground plane; not finite without one
  Light(const TracedScene& scene, SunPosition sun, float ground_m);

  /// Light that arrives along a ray, linear RGB.
  Eigen::Vector3f along(const Ray& ray, Random& random, int depth = 0) const;

 private:
  std::optional<Hit> first_hit(const Ray& ray) const;
  Eigen::Vector3f sky(const Eigen::Vector3f& direction) const;
  Eigen::Vector3f scattered(const Hit& hit,
                            const Eigen::Vector3f& normal,
                            const Eigen::Vector3f& flat_normal,
                            Random& random) const;
  Eigen::Vector3f from_sun(const Hit& hit,
                           const Eigen::Vector3f& normal,
                           const Eigen::Vector3f& flat_normal,
                           Random& random) const;
  Eigen::Vector3f from_sky(const Hit& hit,
                           const Eigen::Vector3f& normal,
                           const Eigen::Vector3f& flat_normal,
                           Random& random) const;

  const TracedScene& scene_;
  Eigen::Vector3f to_sun_;
  Eigen::Vector3f sun_color_;
  Eigen::Vector3f zenith_;
  Eigen::Vector3f horizon_;
  float ground_m_;
  Material ground_;
  float scale_m_;  ///< of the scene, by which distance fades the ground into the horizon
};

/// Direction to the sky at an azimuth (clockwise from north) and elevation; x east, y up, z south.
Eigen::Vector3f sky_direction(double azimuth_deg, double elevation_deg);

}  // namespace silvafit::render
