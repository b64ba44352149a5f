// SPDX-License-Identifier: MIT
// A scene in Embree: intersections of rays.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/render/ray_tracer.hpp"

namespace silvafit::render {

struct Ray {
  Eigen::Vector3f origin;
  Eigen::Vector3f direction;  ///< of length 1
};

/// The point where a ray meets a surface.
struct Hit {
  float distance = std::numeric_limits<float>::infinity();
  Eigen::Vector3f at{0, 0, 0};
  Eigen::Vector3f flat_normal{0, 1, 0};   ///< of the triangle, as it is wound; of length 1
  Eigen::Vector3f normal{0, 1, 0};        ///< by its vertices and the normal map; of length 1
  Eigen::Vector3f facet_normal{0, 1, 0};  ///< of the triangle, with the normal map; of length 1
  Eigen::Vector3f color{1, 1, 1};
  const Material* material = nullptr;
  bool is_ground = false;
};

class TracedScene {
 public:
  /// \throws as RayTracer
  explicit TracedScene(const Scene& scene);

  std::optional<Hit> nearest(const Ray& ray) const;
  bool is_blocked(const Ray& ray) const;
  const std::array<Eigen::Vector3f, 2>& bounds() const { return bounds_; }
  std::size_t triangle_count() const { return triangles_; }
  /// The extreme points of the scene in many directions.
  std::vector<Eigen::Vector3f> outline() const;

 private:
  struct DeviceRelease {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  };
  struct SceneRelease {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
  using Geometry = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

  Geometry build(const Model& model) const;
  void add(const Instance& instance, RTCScene scene);
  void check_device() const;

  std::vector<Model> models_;
  std::vector<std::size_t> model_of_;               ///< by instance
  std::vector<Eigen::Matrix4f> transforms_;         ///< by instance
  std::vector<Eigen::Matrix3f> normal_transforms_;  ///< by instance
  std::unique_ptr<std::string> device_message_ = std::make_unique<std::string>();
  Device device_;
  std::vector<Geometry> model_scenes_;
  Geometry scene_;
  std::array<Eigen::Vector3f, 2> bounds_;
  std::size_t triangles_ = 0;
};

}  // namespace silvafit::render
