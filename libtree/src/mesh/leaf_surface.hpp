// SPDX-License-Identifier: MIT
// Leaves of the foliage of a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/crown_light.hpp"
#include "mesh/leaf_corner.hpp"
#include "mesh/part_builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Points of one spray or tuft and the leaves between them.
///
/// Neighboring leaves share their points, which halves the size of a mesh.
class LeafSurface {
 public:
  LeafSurface(const Crown& crown,
              const Foliage& foliage,
              const MeshOptions& options,
              PartBuilder& build);

  /// Starts a spray, with its maximum size and its brightness.
  void begin(std::size_t points, std::size_t leaves, std::size_t fillings, double shade);

  /// A point, moved into the crown if it is outside.
  /// \param lean  inclination of the surface relative to the crown's; much shorter than 1
  /// \returns its index in the spray
  std::size_t point(Point at, Point lean = {});
  Point at(std::size_t number) const { return points_[number].at; }

  /// A leaf folded along its middle, counterclockwise from its base.
  void leaf(std::size_t base, std::size_t right, std::size_t tip, std::size_t left);
  void triangle(std::size_t a, std::size_t b, std::size_t c);

  /// Away from the inside of the crown, as on an ellipsoid with the crown's width and length.
  Point outward_of(Point at) const { return light_.outward(at); }

 private:
  Bytes4 color_at(Point at) const;

  const Crown& crown_;
  const Foliage& foliage_;
  const MeshOptions& options_;
  PartBuilder& build_;
  CrownLight light_;
  std::vector<LeafCorner> points_;
  double shade_ = 1.0;
};

}  // namespace silvafit::tree
