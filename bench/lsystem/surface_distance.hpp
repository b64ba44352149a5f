// SPDX-License-Identifier: MIT
// The largest distance between two surfaces, by dense samples.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::bench {

using Triangle = std::array<tree::Point, 3>;

/// Stem and branches.
std::vector<Triangle> wood_of(const tree::Mesh& mesh);

/// Finds the nearest triangle: a tree of boxes, halved at the middle triangle along the longest
/// side.
class NearestSurface {
 public:
  explicit NearestSurface(std::vector<Triangle> triangles);

  /// The distance to the surface, or some larger one that is not above `enough_m`.
  double distance_m(tree::Point place, double enough_m) const;

 private:
  struct Box {
    tree::Point low{};
    tree::Point high{};
    std::size_t first = 0;
    std::size_t count = 0;  ///< triangles of a leaf; 0 where it has two halves
    std::size_t right = 0;  ///< its second half; the first one is the next box
  };

  std::size_t build(std::size_t first, std::size_t count);
  static double squared_distance(const Box& box, tree::Point place);

  std::vector<Triangle> triangles_;
  std::vector<Box> boxes_;
};

/// The largest distance of `from` from a surface at places that stand at most `spacing_m` apart, a
/// corner of each triangle among them [m].
double farthest_m(const std::vector<Triangle>& from, const NearestSurface& to, double spacing_m);

}  // namespace silvafit::bench
