// SPDX-License-Identifier: MIT
#include "silvafit/render/forest_floor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <utility>

#include "noise.hpp"
#include "silvafit/base/random.hpp"
#include "traced_scene.hpp"

namespace silvafit::render {
namespace {

// Beyond this, plants of 0.3 m are smaller than a pixel or two, and stems hide most of the floor.
constexpr double kReach_m = 25.0;
constexpr double kCell_m = 0.5;

/// Adds a thin leaf of two triangles each half, from a point along a direction that bends down.
void add_blade(Surface& surface,
               const Vector& from,
               double azimuth,
               double length,
               double width,
               double rise) {
  const double east = std::cos(azimuth);
  const double south = std::sin(azimuth);
  const auto first = static_cast<std::uint32_t>(surface.positions.size() / 3);
  const auto add = [&](double along, double up, double side) {
    for (const double value : {from[0] + along * east - side * south,
                               from[1] + up,
                               from[2] + along * south + side * east}) {
      surface.positions.push_back(static_cast<float>(value));
    }
  };
  const double half = 0.5 * width;
  add(0.0, 0.0, half);
  add(0.0, 0.0, -half);
  add(0.5 * length, rise, half);
  add(0.5 * length, rise, -half);
  add(length, 0.6 * rise, 0.0);
  for (const std::uint32_t corner : {0U, 1U, 2U, 2U, 1U, 3U, 2U, 3U, 4U}) {
    surface.indices.push_back(first + corner);
  }
}

Material leaf(const Vector& color) {
  return {.color = color, .translucency = 0.4, .double_sided = true};
}

/// A tuft of grass.
Model grass(Random& random) {
  Surface surface{.material = leaf({0.10, 0.17, 0.04})};
  for (int blade = 0; blade < 14; ++blade) {
    const double turn = 2.0 * std::numbers::pi * random.uniform();
    const double length = 0.10 + 0.22 * random.uniform();
    add_blade(surface,
              {0.04 * random.normal(), 0.0, 0.04 * random.normal()},
              turn,
              0.6 * length,
              0.006,
              length);
  }
  return {.surfaces = {std::move(surface)}};
}

/// A rosette of broad leaves.
Model herb(Random& random) {
  Surface surface{.material = leaf({0.07, 0.15, 0.05})};
  for (int k = 0; k < 9; ++k) {
    const double turn = 2.4 * k + 0.3 * random.normal();
    add_blade(surface,
              {0.0, 0.01, 0.0},
              turn,
              0.10 + 0.08 * random.uniform(),
              0.05,
              0.05 + 0.08 * random.uniform());
  }
  return {.surfaces = {std::move(surface)}};
}

/// Fallen leaves of one color on a patch.
Model litter(Random& random, const Vector& color) {
  Surface surface{.material = leaf(color)};
  for (int k = 0; k < 16; ++k) {
    add_blade(surface,
              {0.3 * random.normal(), 0.004 + 0.01 * random.uniform(), 0.3 * random.normal()},
              2.0 * std::numbers::pi * random.uniform(),
              0.05 + 0.04 * random.uniform(),
              0.03,
              0.012 * random.uniform());
  }
  return {.surfaces = {std::move(surface)}};
}

/// A fallen branch, a bent prism.
Model branch(Random& random) {
  constexpr int kSides = 5;
  constexpr int kRings = 5;
  Surface surface{.material = {.color = {0.10, 0.08, 0.06}}};
  const double length = 0.4 + 1.2 * random.uniform();
  const double bend = 0.15 * length * random.normal();
  for (int ring = 0; ring <= kRings; ++ring) {
    const double share = static_cast<double>(ring) / kRings;
    const double radius = 0.012 * length * (1.0 - 0.8 * share);
    for (int side = 0; side < kSides; ++side) {
      const double angle = 2.0 * std::numbers::pi * side / kSides;
      surface.positions.push_back(static_cast<float>(length * (share - 0.5)));
      surface.positions.push_back(static_cast<float>(radius * (1.0 + std::cos(angle))));
      surface.positions.push_back(
          static_cast<float>(4.0 * bend * share * (1.0 - share) + radius * std::sin(angle)));
    }
  }
  for (std::uint32_t ring = 0; ring < kRings; ++ring) {
    for (std::uint32_t side = 0; side < kSides; ++side) {
      const std::uint32_t a = ring * kSides + side;
      const std::uint32_t b = ring * kSides + (side + 1) % kSides;
      for (const std::uint32_t corner : {a, a + kSides, b, b, a + kSides, b + kSides}) {
        surface.indices.push_back(corner);
      }
    }
  }
  return {.surfaces = {std::move(surface)}};
}

/// A kind of scenery: some models of it, and how many stand in a square meter where it is densest.
struct Kind {
  std::vector<std::size_t> models{};
  double per_m2 = 0.0;
  double patch_m = 0.0;  ///< size of its patches
};

Kind add_kind(Scene& scene, double per_m2, double patch_m, std::vector<Model> models) {
  Kind kind{.per_m2 = per_m2, .patch_m = patch_m};
  for (Model& model : models) {
    kind.models.push_back(scene.models.size());
    scene.models.push_back(std::move(model));
  }
  return kind;
}

std::vector<Kind> add_kinds(Scene& scene, Random& random) {
  std::vector<Kind> kinds;
  kinds.push_back(add_kind(scene,
                           7.0,
                           3.0,
                           {litter(random, {0.16, 0.09, 0.04}),
                            litter(random, {0.22, 0.15, 0.07}),
                            litter(random, {0.11, 0.07, 0.04})}));
  kinds.push_back(add_kind(scene, 8.0, 5.0, {grass(random), grass(random), grass(random)}));
  kinds.push_back(add_kind(scene, 1.5, 4.0, {herb(random), herb(random)}));
  kinds.push_back(add_kind(scene, 0.08, 8.0, {branch(random), branch(random), branch(random)}));
  return kinds;
}

/// Turned about the vertical, larger or smaller, at a place.
Instance placed(std::size_t model, const Vector& at, Random& random) {
  const double turn = 2.0 * std::numbers::pi * random.uniform();
  const double size = 0.7 + 0.6 * random.uniform();
  const double c = size * std::cos(turn);
  const double s = size * std::sin(turn);
  return {.model = model,
          .transform = {c, 0, s, 0, 0, size, 0, 0, -s, 0, c, 0, at[0], at[1], at[2], 1}};
}

/// The outline of a ground, and points outside of it.
class Outside {
 public:
  Outside(const Surface& surface, const Eigen::Matrix4d& transform) {
    for (std::size_t k = 0; k + 2 < surface.positions.size(); k += 3) {
      const Eigen::Vector4d point(
          surface.positions[k], surface.positions[k + 1], surface.positions[k + 2], 1.0);
      points_.emplace_back((transform * point).head<3>());
      middle_ += points_.back();
    }
    middle_ /= static_cast<double>(points_.size());
    // An edge of the outline belongs to one triangle; vertices of one place are one.
    std::map<std::array<double, 3>, std::uint32_t> numbers;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> triangles;
    const auto number = [&](std::uint32_t vertex) {
      const Eigen::Vector3d& at = points_[vertex];
      return numbers.try_emplace({at.x(), at.y(), at.z()}, vertex).first->second;
    };
    for (std::size_t k = 0; k < surface.indices.size(); ++k) {
      const std::size_t next = k % 3 == 2 ? k - 2 : k + 1;
      const std::uint32_t a = number(surface.indices[k]);
      const std::uint32_t b = number(surface.indices[next]);
      ++triangles[{std::min(a, b), std::max(a, b)}];
    }
    for (const auto& [edge, count] : triangles) {
      if (count == 1) edges_.push_back(edge);
    }
  }

  const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges() const { return edges_; }
  const Eigen::Vector3d& at(std::uint32_t vertex) const { return points_[vertex]; }
  /// As far from the edge as that is from the middle, at half of its difference in height.
  Eigen::Vector3d near(std::uint32_t vertex) const { return moved(vertex, 2.0, 0.5); }
  Eigen::Vector3d far(std::uint32_t vertex) const {
    constexpr double kHorizon_m = 5000.0;
    const Eigen::Vector3d from = points_[vertex] - middle_;
    return moved(vertex, 1.0 + kHorizon_m / std::max(1.0, std::hypot(from.x(), from.z())), 0.0);
  }

 private:
  Eigen::Vector3d moved(std::uint32_t vertex, double times, double height) const {
    const Eigen::Vector3d from = points_[vertex] - middle_;
    return middle_ + Eigen::Vector3d(times * from.x(), height * from.y(), times * from.z());
  }

  std::vector<Eigen::Vector3d> points_{};
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero();
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_{};
};

}  // namespace

struct GroundHeight::State {
  std::unique_ptr<const TracedScene> surfaces{};  ///< null without ground
  std::array<Vector, 2> bounds{};
  double above = 0.0;
};

GroundHeight::GroundHeight(const Scene& scene) : state_(std::make_unique<State>()) {
  const TracedScene whole(scene);
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Vector3f& corner = whole.bounds()[k];
    state_->bounds[k] = {corner.x(), corner.y(), corner.z()};
  }
  Scene ground;
  std::map<std::size_t, std::size_t> of_model;
  for (std::size_t k = 0; k < scene.models.size(); ++k) {
    Model model;
    std::ranges::copy_if(
        scene.models[k].surfaces, std::back_inserter(model.surfaces), &Surface::is_ground);
    if (model.surfaces.empty()) continue;
    of_model[k] = ground.models.size();
    ground.models.push_back(std::move(model));
  }
  for (const Instance& instance : scene.instances) {
    const auto found = of_model.find(instance.model);
    if (found == of_model.end()) continue;
    ground.instances.push_back({.model = found->second, .transform = instance.transform});
  }
  if (ground.instances.empty()) return;
  state_->surfaces = std::make_unique<const TracedScene>(ground);
  state_->above = state_->surfaces->bounds()[1].y() + 1.0;
}

GroundHeight::~GroundHeight() = default;
GroundHeight::GroundHeight(GroundHeight&&) noexcept = default;
GroundHeight& GroundHeight::operator=(GroundHeight&&) noexcept = default;

double GroundHeight::at(double x, double z) const {
  const double lowest = state_->bounds[0][1];
  if (!state_->surfaces) return lowest;
  const Eigen::Vector3f from = Eigen::Vector3d(x, state_->above, z).cast<float>();
  const auto hit = state_->surfaces->nearest({from, -Eigen::Vector3f::UnitY()});
  return hit ? static_cast<double>(hit->at.y()) : lowest;
}

const std::array<Vector, 2>& GroundHeight::bounds() const { return state_->bounds; }

void extend_ground(Scene& scene) {
  Surface skirt;
  const auto add = [&skirt](const Eigen::Vector3d& point) {
    for (const double value : point) skirt.positions.push_back(static_cast<float>(value));
    // Shaded as level ground: its few large triangles would be seen.
    skirt.normals.insert(skirt.normals.end(), {0.0F, 1.0F, 0.0F});
  };
  for (const Instance& instance : scene.instances) {
    for (const Surface& surface : scene.models[instance.model].surfaces) {
      if (!surface.is_ground) continue;
      const Outside outside(surface, Eigen::Map<const Eigen::Matrix4d>(instance.transform.data()));
      skirt.material = surface.material;
      for (const auto& [from, to] : outside.edges()) {
        const auto first = static_cast<std::uint32_t>(skirt.positions.size() / 3);
        for (const std::uint32_t vertex : {from, to}) {
          add(outside.at(vertex));
          add(outside.near(vertex));
          add(outside.far(vertex));
        }
        // Of two strips, between the edge, a place near it and the horizon.
        for (const std::uint32_t k : {0U, 1U}) {
          for (const std::uint32_t corner : {k, k + 1, k + 3, k + 3, k + 1, k + 4}) {
            skirt.indices.push_back(first + corner);
          }
        }
      }
    }
  }
  if (skirt.indices.empty()) return;
  skirt.material.double_sided = true;
  skirt.is_ground = true;
  scene.instances.push_back({.model = scene.models.size()});
  scene.models.push_back({.surfaces = {std::move(skirt)}});
}

void add_forest_floor(Scene& scene,
                      const GroundHeight& ground,
                      const std::vector<Vector>& places,
                      std::uint64_t seed) {
  Random shapes(seed);
  const std::vector<Kind> kinds = add_kinds(scene, shapes);
  std::set<std::pair<long, long>> cells;
  const long reach = std::lround(kReach_m / kCell_m);
  for (const Vector& place : places) {
    const long column = std::lround(place[0] / kCell_m);
    const long row = std::lround(place[2] / kCell_m);
    for (long i = -reach; i <= reach; ++i) {
      for (long j = -reach; j <= reach; ++j) {
        if (i * i + j * j <= reach * reach) cells.emplace(column + i, row + j);
      }
    }
  }
  for (const std::pair<long, long>& cell : cells) {
    const auto key = static_cast<std::uint64_t>(cell.first) * 0x9E3779B97F4A7C15ULL +
                     static_cast<std::uint64_t>(cell.second);
    Random random(seed, key);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      const Kind& kind = kinds[k];
      const double x = kCell_m * static_cast<double>(cell.first);
      const double z = kCell_m * static_cast<double>(cell.second);
      const auto share =
          fractal_noise(static_cast<float>(x / kind.patch_m) + 31.0F * static_cast<float>(k),
                        static_cast<float>(z / kind.patch_m),
                        2);
      // Half of the ground is outside of patches.
      const double density = kind.per_m2 * std::clamp(4.0 * (share - 0.4), 0.0, 1.0);
      const double expected = density * kCell_m * kCell_m;
      const auto count = static_cast<int>(std::floor(expected + random.uniform()));
      for (int i = 0; i < count; ++i) {
        const double east = x + kCell_m * random.uniform();
        const double south = z + kCell_m * random.uniform();
        const std::size_t model = kind.models[random.below(kind.models.size())];
        scene.instances.push_back(placed(model, {east, ground.at(east, south), south}, random));
      }
    }
  }
}

}  // namespace silvafit::render
