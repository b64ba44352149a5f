// SPDX-License-Identifier: MIT
#include "mesh/leaf_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/sliver.hpp"

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
  build_.reserve(options_.textured ? 4 * leaves + 3 * fillings : points, 2 * leaves + fillings);
}

std::size_t LeafSurface::point(Point at, Point lean) {
  const Point inside = crown_.confine(at);
  const Point normal = direction(light_.stretched(inside) + CrownLight::kAbove + lean);
  LeafCorner added{inside, normal};
  if (!options_.textured) {
    added.vertex = build_.vertex(inside, normal);
    if (options_.vertex_colors) build_.color(color_at(inside));
  }
  points_.push_back(added);
  return points_.size() - 1;
}

void LeafSurface::leaf(std::size_t base, std::size_t right, std::size_t tip, std::size_t left) {
  if (options_.textured) {
    card(base, right, tip, left);
  } else {
    triangle(base, right, tip);
    triangle(base, tip, left);
  }
}

void LeafSurface::fill(std::size_t first, std::size_t tip, std::size_t second) {
  if (options_.textured) {
    triangular_card(first, tip, second);
  } else {
    triangle(first, tip, second);
  }
}

void LeafSurface::triangle(std::size_t a, std::size_t b, std::size_t c) {
  add_leaf_triangle(points_[a], points_[b], points_[c], build_);
}

void LeafSurface::card(std::size_t base, std::size_t right, std::size_t tip, std::size_t left) {
  std::array<LeafCorner, 4> corners{points_[base], points_[right], points_[tip], points_[left]};
  std::array<double, 4> across{0.5, 1.0, 0.5, 0.0};
  const Point axis = corners[2].at - corners[0].at;
  const double squared = dot(axis, axis);
  Point sum{};
  for (const LeafCorner& corner : corners) sum = sum + corner.normal;
  const Point face =
      cross(corners[1].at - corners[0].at, axis) + cross(axis, corners[3].at - corners[0].at);
  if (dot(face, sum) < 0.0) std::swap(corners[1], corners[3]);
  const Point sideways = corners[1].at - corners[3].at;
  for (std::size_t i = 0; i < 4; ++i) {
    LeafCorner& corner = corners[i];
    const double rise = squared > 0.0 ? dot(corner.at - corners[0].at, axis) / squared : 0.5;
    corner.vertex =
        card_vertex(corner, sideways, axis, across[i], 1.0 - std::clamp(rise, 0.0, 1.0));
  }
  // One half of a folded leaf may face away; each half is oriented by its own normals.
  add_leaf_triangle(corners[0], corners[1], corners[2], build_);
  add_leaf_triangle(corners[0], corners[2], corners[3], build_);
}

/// The middle of an image, without its corners: the shoot goes to the tip.
void LeafSurface::triangular_card(std::size_t first, std::size_t tip, std::size_t second) {
  LeafCorner left = points_[first];
  LeafCorner right = points_[second];
  const LeafCorner& end = points_[tip];
  const Point axis = end.at - 0.5 * (left.at + right.at);
  const Point face = cross(right.at - left.at, axis);
  if (is_sliver(right.at - left.at, end.at - left.at, face)) return;
  if (dot(face, left.normal + right.normal + end.normal) < 0.0) std::swap(left, right);
  const Point sideways = right.at - left.at;
  constexpr double kBase = 0.75;
  constexpr double kTip = 0.1;
  const std::uint32_t a = card_vertex(left, sideways, axis, 0.15, kBase);
  const std::uint32_t b = card_vertex(right, sideways, axis, 0.85, kBase);
  build_.triangle(a, b, card_vertex(end, sideways, axis, 0.5, kTip));
}

std::uint32_t LeafSurface::card_vertex(
    const LeafCorner& corner, Point sideways, Point axis, double u, double v) {
  const std::uint32_t vertex = build_.vertex(corner.at, corner.normal);
  // Tangential to the surface with this normal.
  const Point flat = sideways - dot(sideways, corner.normal) * corner.normal;
  const Point other = cross(corner.normal, {0.0, 0.0, 1.0});
  const Point tangent = direction(flat, direction(other, {1.0, 0.0, 0.0}));
  // glTF's bitangent points up in the image, where v decreases.
  const float sign = dot(cross(corner.normal, tangent), axis) >= 0.0 ? 1.0F : -1.0F;
  build_.texture({.u = u, .v = v, .tangent = tangent, .sign = sign});
  if (options_.vertex_colors) build_.color(color_at(corner.at));
  return vertex;
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
