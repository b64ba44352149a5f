// SPDX-License-Identifier: MIT
#include "traced_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <string>
#include <system_error>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "texture_sampling.hpp"

namespace silvafit::render {
namespace {

using Eigen::Matrix3f;
using Eigen::Matrix4d;
using Eigen::Vector3f;

void check(const Surface& surface) {
  const std::size_t vertices = surface.positions.size() / 3;
  const auto fits = [vertices](std::size_t size, std::size_t each) {
    return size == 0 || size == vertices * each;
  };
  const bool is_whole = surface.positions.size() == 3 * vertices &&
                        surface.indices.size() % 3 == 0 && fits(surface.normals.size(), 3) &&
                        fits(surface.colors.size(), 4) && fits(surface.uvs.size(), 2);
  const bool is_inside = std::ranges::all_of(
      surface.indices, [vertices](std::uint32_t index) { return index < vertices; });
  if (!is_whole || !is_inside) {
    throw UsageError("the buffers of a surface differ in length");
  }
  const auto is_finite = [](float value) { return std::isfinite(value); };
  // Embree's largest coordinate is 1.8e18.
  const auto is_possible = [](float value) { return std::abs(value) <= 1e18F; };
  if (!std::ranges::all_of(surface.positions, is_possible) ||
      !std::ranges::all_of(surface.uvs, is_finite)) {
    throw UsageError("a surface has a coordinate that is not finite, or beyond 1e18 m");
  }
}

/// A texture without UVs or without pixels is ignored.
bool has_picture(const Surface& surface) {
  return surface.texture != nullptr && !surface.uvs.empty() && !surface.texture->rgba.empty();
}

bool has_normal_map(const Surface& surface) {
  return surface.normal_texture != nullptr && !surface.uvs.empty() &&
         !surface.normal_texture->rgba.empty();
}

void check_pixels(const tree::Texture& texture) {
  if (texture.rgba.size() != 4 * texture.width * texture.height) {
    throw UsageError("the number of pixels of a texture must be width times height");
  }
}

void check_pictures(const Surface& surface) {
  if (has_picture(surface)) check_pixels(*surface.texture);
  if (has_normal_map(surface)) check_pixels(*surface.normal_texture);
}

/// The point of the texture where a triangle was hit.
std::array<float, 2> place_in_picture(const Surface& surface,
                                      std::uint32_t triangle,
                                      float second,
                                      float third) {
  const std::uint32_t* corners = surface.indices.data() + std::size_t{3} * triangle;
  std::array<float, 2> place{};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto at = [&](int corner) { return surface.uvs[std::size_t{2} * corners[corner] + k]; };
    place[k] = (1.0F - second - third) * at(0) + second * at(1) + third * at(2);
  }
  return place;
}

/// The normal of a normal map: x along increasing u, y along decreasing v, z outward, each stored
/// as a half of itself plus a half.
Vector3f bent_normal(const Surface& surface,
                     std::uint32_t triangle,
                     const Matrix3f& turn,
                     const Vector3f& normal,
                     const Vector3f& stored) {
  const std::uint32_t* corners = surface.indices.data() + std::size_t{3} * triangle;
  const auto at = [&](int corner) {
    return Vector3f(
        Eigen::Map<const Vector3f>(surface.positions.data() + std::size_t{3} * corners[corner]));
  };
  const auto uv = [&](int corner) {
    return Eigen::Vector2f(surface.uvs[std::size_t{2} * corners[corner]],
                           surface.uvs[std::size_t{2} * corners[corner] + 1]);
  };
  const Vector3f a = turn * (at(1) - at(0));
  const Vector3f b = turn * (at(2) - at(0));
  const Eigen::Vector2f p = uv(1) - uv(0);
  const Eigen::Vector2f q = uv(2) - uv(0);
  const float area = p.x() * q.y() - q.x() * p.y();
  if (std::abs(area) < 1e-12F) return normal;
  const Vector3f to_right = (q.y() * a - p.y() * b) / area;
  const Vector3f to_top = -(p.x() * b - q.x() * a) / area;
  const Vector3f x = to_right - normal.dot(to_right) * normal;
  if (!(x.squaredNorm() > 0.0F)) return normal;
  const Vector3f tangent = x.normalized();
  Vector3f bitangent = normal.cross(tangent);
  if (bitangent.dot(to_top) < 0.0F) bitangent = -bitangent;
  const Vector3f flat = 2.0F * stored - Vector3f::Ones();
  const Vector3f bent = flat.x() * tangent + flat.y() * bitangent + flat.z() * normal;
  return bent.squaredNorm() > 0.0F ? Vector3f(bent.normalized()) : normal;
}

/// The cosine between a ray and the normal of the triangle that it hits: positive if it comes from
/// the side from which the triangle is wound clockwise.
float cosine_of(const RTCFilterFunctionNArguments* hit, unsigned i) {
  const Vector3f normal(RTCHitN_Ng_x(hit->hit, hit->N, i),
                        RTCHitN_Ng_y(hit->hit, hit->N, i),
                        RTCHitN_Ng_z(hit->hit, hit->N, i));
  const Vector3f along(RTCRayN_dir_x(hit->ray, hit->N, i),
                       RTCRayN_dir_y(hit->ray, hit->N, i),
                       RTCRayN_dir_z(hit->ray, hit->N, i));
  return normal.dot(along) / (normal.norm() * along.norm());
}

/// As in glTF viewers, rays pass where a texture is less than half opaque, and they pass the backs
/// of pictures that have only one side. They pass pictures of leaves that are seen from their edge,
/// which would look like a streak.
void pass_transparent(const RTCFilterFunctionNArguments* hit) {
  constexpr float kOpaque = 0.5F;
  constexpr float kEdge = 0.12F;
  const auto& surface = *static_cast<const Surface*>(hit->geometryUserPtr);
  for (unsigned i = 0; i < hit->N; ++i) {
    if (hit->valid[i] == 0) continue;
    const float cosine = cosine_of(hit, i);
    const bool is_back = !surface.material.double_sided && cosine > 0.0F;
    const bool is_edge = surface.material.translucency > 0.0 && std::abs(cosine) < kEdge;
    if (is_back || is_edge) {
      hit->valid[i] = 0;
      continue;
    }
    const auto [u, v] = place_in_picture(surface,
                                         RTCHitN_primID(hit->hit, hit->N, i),
                                         RTCHitN_u(hit->hit, hit->N, i),
                                         RTCHitN_v(hit->hit, hit->N, i));
    if (opacity(*surface.texture, u, v) < kOpaque) hit->valid[i] = 0;
  }
}

void check(const Scene& scene) {
  std::size_t triangles = 0;
  for (const Model& model : scene.models) {
    for (const Surface& surface : model.surfaces) {
      check(surface);
      check_pictures(surface);
    }
  }
  for (const Instance& instance : scene.instances) {
    if (instance.model >= scene.models.size()) {
      throw UsageError(fmt::format("an instance refers to model {}, but there are {} models",
                                   instance.model,
                                   scene.models.size()));
    }
    for (const Surface& surface : scene.models[instance.model].surfaces) {
      triangles += surface.indices.size() / 3;
    }
  }
  if (triangles == 0) throw UsageError("the scene has no triangles");
}

/// Directions on the whole sphere (Fibonacci's spiral).
std::vector<Vector3f> directions_all_round() {
  constexpr int kNumber = 96;
  constexpr double kGoldenAngle = 2.399963229728653;
  std::vector<Vector3f> result;
  for (int i = 0; i < kNumber; ++i) {
    const double height = 1.0 - 2.0 * (i + 0.5) / kNumber;
    const double level = std::sqrt(1.0 - height * height);
    result.push_back(Eigen::Vector3d(level * std::cos(kGoldenAngle * i),
                                     height,
                                     level * std::sin(kGoldenAngle * i))
                         .cast<float>());
  }
  for (int axis = 0; axis < 3; ++axis) {
    result.emplace_back(Vector3f::Unit(axis));
    result.emplace_back(-Vector3f::Unit(axis));
  }
  return result;
}

/// The used vertices of a model that are farthest in each of the directions.
std::vector<Vector3f> farthest_vertices(const Model& model,
                                        const std::vector<Vector3f>& directions) {
  std::vector<Vector3f> points(directions.size(), Vector3f::Zero());
  std::vector<float> reach(directions.size(), -std::numeric_limits<float>::infinity());
  for (const Surface& surface : model.surfaces) {
    for (const std::uint32_t index : surface.indices) {
      const Vector3f at =
          Eigen::Map<const Vector3f>(surface.positions.data() + std::size_t{3} * index);
      for (std::size_t k = 0; k < directions.size(); ++k) {
        const float along = directions[k].dot(at);
        if (along <= reach[k]) continue;
        reach[k] = along;
        points[k] = at;
      }
    }
  }
  if (!points.empty() && std::isinf(reach.front())) points.clear();
  return points;
}

Vector3f vertex(const std::vector<float>& values, std::uint32_t index) {
  return Eigen::Map<const Vector3f>(values.data() + std::size_t{3} * index);
}

Vector3f color_of(const Surface& surface, std::uint32_t index) {
  constexpr float kWhole = 1.0F / 255.0F;
  const std::uint8_t* color = surface.colors.data() + std::size_t{4} * index;
  return kWhole * Vector3f(color[0], color[1], color[2]);
}

Vector3f to_float(const Vector& value) {
  return Eigen::Map<const Eigen::Vector3d>(value.data()).cast<float>();
}

/// Except for memory and threads, failures of Embree are errors of the program.
/// \param message  of Embree, or empty
[[noreturn]] void fail(RTCError error, const std::string& message) {
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  // Embree has no code for threads that cannot start; too little memory for their stacks is one
  // reason.
  if (message.starts_with("pthread_create")) {
    throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
  }
  throw Error(fmt::format("the ray tracing library (Embree) failed with error {}: {}",
                          static_cast<int>(error),
                          message));
}

/// Keeps the message of Embree's first error.
void keep_message(void* kept, RTCError /*error*/, const char* message) {
  auto& first = *static_cast<std::string*>(kept);
  if (first.empty() && message != nullptr) first = message;
}

RTCRay to_embree(const Ray& ray) {
  RTCRay result{};
  result.org_x = ray.origin.x();
  result.org_y = ray.origin.y();
  result.org_z = ray.origin.z();
  result.dir_x = ray.direction.x();
  result.dir_y = ray.direction.y();
  result.dir_z = ray.direction.z();
  result.tfar = std::numeric_limits<float>::infinity();
  result.mask = static_cast<unsigned>(-1);
  return result;
}

}  // namespace

TracedScene::TracedScene(const Scene& scene)
    : models_(scene.models), device_(rtcNewDevice(nullptr)) {
  check(scene);
  if (!device_) fail(rtcGetDeviceError(nullptr), "no device");
  rtcSetDeviceErrorFunction(device_.get(), keep_message, device_message_.get());
  for (const Model& model : models_) model_scenes_.push_back(build(model));
  scene_.reset(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
  for (const Instance& instance : scene.instances) add(instance, scene_.get());
  rtcCommitScene(scene_.get());
  check_device();
  RTCBounds bounds{};
  rtcGetSceneBounds(scene_.get(), &bounds);
  bounds_ = {Vector3f(bounds.lower_x, bounds.lower_y, bounds.lower_z),
             Vector3f(bounds.upper_x, bounds.upper_y, bounds.upper_z)};
}

void TracedScene::check_device() const {
  const RTCError error = rtcGetDeviceError(device_.get());
  if (error != RTC_ERROR_NONE) fail(error, *device_message_);
}

TracedScene::Geometry TracedScene::build(const Model& model) const {
  Geometry scene(rtcNewScene(device_.get()));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (const Surface& surface : model.surfaces) {
    const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    const auto copy = [geometry](RTCBufferType type, RTCFormat format, const auto& values) {
      if (values.empty()) return;
      void* const target = rtcSetNewGeometryBuffer(
          geometry, type, 0, format, 3 * sizeof(values.front()), values.size() / 3);
      if (target != nullptr) {
        std::memcpy(target, values.data(), values.size() * sizeof(values.front()));
      }
    };
    copy(RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, surface.positions);
    copy(RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, surface.indices);
    if (has_picture(surface) && tree::has_transparency(*surface.texture)) {
      // Embree returns the pointer and does not write through it.
      rtcSetGeometryUserData(geometry, const_cast<Surface*>(&surface));
      rtcSetGeometryIntersectFilterFunction(geometry, pass_transparent);
      rtcSetGeometryOccludedFilterFunction(geometry, pass_transparent);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.get(), geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene.get());
  check_device();
  return scene;
}

void TracedScene::add(const Instance& instance, RTCScene scene) {
  const Matrix4d transform = Eigen::Map<const Matrix4d>(instance.transform.data());
  const Eigen::Matrix4f rounded = transform.cast<float>();
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, model_scenes_[instance.model].get());
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, rounded.data());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  if (tree::is_flattened(instance.transform)) {
    throw UsageError("an instance is scaled to 0 in one direction");
  }
  const Matrix3f linear = rounded.topLeftCorner<3, 3>();
  transforms_.push_back(rounded);
  normal_transforms_.emplace_back(linear.inverse().transpose());
  model_of_.push_back(instance.model);
  for (const Surface& surface : models_[instance.model].surfaces) {
    triangles_ += surface.indices.size() / 3;
  }
}

std::optional<Hit> TracedScene::nearest(const Ray& ray) const {
  RTCRayHit query{};
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_.get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;

  const std::size_t number = query.hit.instID[0];
  const Surface& surface = models_[model_of_[number]].surfaces[query.hit.geomID];
  const Matrix3f& turn = normal_transforms_[number];
  const std::uint32_t* corners = surface.indices.data() + std::size_t{3} * query.hit.primID;
  const Vector3f weights(1.0F - query.hit.u - query.hit.v, query.hit.u, query.hit.v);
  Hit hit{
      .distance = query.ray.tfar, .material = &surface.material, .is_ground = surface.is_ground};
  hit.at = ray.origin + hit.distance * ray.direction;
  hit.flat_normal = (turn * Vector3f(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z)).normalized();
  hit.normal = hit.flat_normal;
  hit.facet_normal = hit.flat_normal;
  hit.color = to_float(surface.material.color);
  if (!surface.normals.empty()) {
    Vector3f sum = Vector3f::Zero();
    for (int k = 0; k < 3; ++k) sum += weights[k] * vertex(surface.normals, corners[k]);
    const Vector3f turned = turn * sum;
    if (turned.squaredNorm() > 0.0F) hit.normal = turned.normalized();
  }
  if (!surface.colors.empty()) {
    Vector3f sum = Vector3f::Zero();
    for (int k = 0; k < 3; ++k) sum += weights[k] * color_of(surface, corners[k]);
    hit.color = hit.color.cwiseProduct(sum);
  }
  if (has_picture(surface)) {
    const auto [u, v] = place_in_picture(surface, query.hit.primID, query.hit.u, query.hit.v);
    hit.color = hit.color.cwiseProduct(sampled(*surface.texture, u, v).head<3>());
  }
  if (has_normal_map(surface)) {
    const auto [u, v] = place_in_picture(surface, query.hit.primID, query.hit.u, query.hit.v);
    const Eigen::Vector4f stored = sampled_as_stored(*surface.normal_texture, u, v);
    const Matrix3f linear = transforms_[number].topLeftCorner<3, 3>();
    const auto bent = [&](const Vector3f& normal) {
      return bent_normal(surface, query.hit.primID, linear, normal, stored.head<3>());
    };
    const bool is_turned = hit.normal.dot(hit.flat_normal) < 0.0F;
    hit.facet_normal = bent(is_turned ? Vector3f(-hit.flat_normal) : hit.flat_normal);
    hit.normal = bent(hit.normal);
  }
  return hit;
}

std::vector<Vector3f> TracedScene::outline() const {
  const std::vector<Vector3f> directions = directions_all_round();
  std::vector<std::vector<Vector3f>> of_models;
  of_models.reserve(models_.size());
  for (const Model& model : models_) of_models.push_back(farthest_vertices(model, directions));
  std::vector<Vector3f> result;
  for (std::size_t i = 0; i < model_of_.size(); ++i) {
    for (const Vector3f& point : of_models[model_of_[i]]) {
      result.emplace_back((transforms_[i] * point.homogeneous()).head<3>());
    }
  }
  return result;
}

bool TracedScene::is_blocked(const Ray& ray) const {
  RTCRay query = to_embree(ray);
  RTCIntersectContext context{};
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene_.get(), &context, &query);
  return query.tfar < 0.0F;
}

}  // namespace silvafit::render
