// SPDX-License-Identifier: MIT
// Litter, grass, herbs and deadwood on the ground around a viewer.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "silvafit/render/ray_tracer.hpp"

namespace silvafit::render {

/// Height of the ground of a scene at a place: of its lowest surface that is ground, else of its
/// lowest point.
class GroundHeight {
 public:
  /// \throws as RayTracer
  explicit GroundHeight(const Scene& scene);
  ~GroundHeight();
  GroundHeight(GroundHeight&&) noexcept;
  GroundHeight& operator=(GroundHeight&&) noexcept;

  /// \param x, z  east and south [m]
  double at(double x, double z) const;
  /// Lowest and highest corner of the scene [m].
  const std::array<Vector, 2>& bounds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Continues the ground of a scene from its edges to the horizon. Nothing without ground.
void extend_ground(Scene& scene);

/// Adds the floor of a forest within 25 m of some places: fallen leaves and grass in patches,
/// herbs, fallen branches. Each square of half a meter has its own random numbers, so that what
/// grows there does not depend on the places. It is scenery, not measured. \param places  [x east,
/// y any, z south]
void add_forest_floor(Scene& scene,
                      const GroundHeight& ground,
                      const std::vector<Vector>& places,
                      std::uint64_t seed);

}  // namespace silvafit::render
