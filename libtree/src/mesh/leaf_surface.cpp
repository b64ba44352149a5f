// SPDX-License-Identifier: MIT
#include "mesh/leaf_surface.hpp"

namespace silvafit::tree {

LeafSurface::LeafSurface(const Crown& crown,
                         const Foliage& foliage,
                         const MeshOptions& options,
                         PartBuilder& build)
    : crown_(crown), foliage_(foliage), options_(options), build_(build), light_(crown) {}

void LeafSurface::begin(std::size_t points,
                        std::size_t leaves,
                        std::size_t fillings,
                        double shade) {
  points_.clear();
  shade_ = shade;
  build_.reserve(points, 2 * leaves + fillings);
}

std::size_t LeafSurface::point(Point at, Point lean) {
  const Point inside = crown_.confine(at);
  const Point normal = direction(light_.stretched(inside) + CrownLight::kAbove + lean);
  points_.push_back({inside, normal, build_.vertex(inside, normal)});
  if (options_.vertex_colors) build_.color(color_at(inside));
  return points_.size() - 1;
}

void LeafSurface::leaf(std::size_t base, std::size_t right, std::size_t tip, std::size_t left) {
  triangle(base, right, tip);
  triangle(base, tip, left);
}

void LeafSurface::triangle(std::size_t a, std::size_t b, std::size_t c) {
  add_leaf_triangle(points_[a], points_[b], points_[c], build_);
}

Bytes4 LeafSurface::color_at(Point at) const {
  const double mix = light_.share(at);
  Bytes4 color{0, 0, 0, 255};
  for (std::size_t i = 0; i < 3; ++i) {
    // The material has the outer color; vertices are relative to it.
    const double value = foliage_.inner[i] + mix * (foliage_.outer[i] - foliage_.inner[i]);
    color[i] = to_byte(shade_ * value / foliage_.outer[i]);
  }
  return color;
}

}  // namespace silvafit::tree
