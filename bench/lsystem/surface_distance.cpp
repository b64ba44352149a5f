// SPDX-License-Identifier: MIT
#include "surface_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "test_support/mesh_test_support.hpp"

namespace silvafit::bench {
namespace {

double along(tree::Point p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

tree::Point middle(const Triangle& t) { return 1.0 / 3.0 * (t[0] + t[1] + t[2]); }

}  // namespace

std::vector<Triangle> wood_of(const tree::Mesh& mesh) {
  std::vector<Triangle> triangles;
  for (const tree::MeshPart& part : mesh.parts) {
    if (part.kind == tree::PartKind::kFoliage) continue;
    for (std::size_t i = 0; i < part.triangle_count(); ++i) {
      triangles.push_back(test::triangle_of(part, i));
    }
  }
  return triangles;
}

NearestSurface::NearestSurface(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  boxes_.reserve(triangles_.size());
  build(0, triangles_.size());
}

std::size_t NearestSurface::build(std::size_t first, std::size_t count) {
  constexpr std::size_t kLeaf = 4;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Box box{.low = {kFar, kFar, kFar}, .high = {-kFar, -kFar, -kFar}, .first = first};
  for (std::size_t i = first; i < first + count; ++i) {
    for (const tree::Point& p : triangles_[i]) {
      box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
      box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
    }
  }
  const std::size_t number = boxes_.size();
  boxes_.push_back(box);
  if (count <= kLeaf) {
    boxes_[number].count = count;
    return number;
  }
  const tree::Point size = box.high - box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto begin = triangles_.begin() + static_cast<std::ptrdiff_t>(first);
  const std::size_t half = count / 2;
  std::nth_element(begin,
                   begin + static_cast<std::ptrdiff_t>(half),
                   begin + static_cast<std::ptrdiff_t>(count),
                   [axis](const Triangle& a, const Triangle& b) {
                     return along(middle(a), axis) < along(middle(b), axis);
                   });
  build(first, half);
  boxes_[number].right = build(first + half, count - half);
  return number;
}

double NearestSurface::squared_distance(const Box& box, tree::Point p) {
  const auto off = [](double x, double low, double high) {
    return std::max({low - x, x - high, 0.0});
  };
  const tree::Point d{off(p.x, box.low.x, box.high.x),
                      off(p.y, box.low.y, box.high.y),
                      off(p.z, box.low.z, box.high.z)};
  return dot(d, d);
}

double NearestSurface::distance_m(tree::Point place, double enough_m) const {
  double least = std::numeric_limits<double>::infinity();
  std::array<std::size_t, 128> waiting{};
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0 && least > enough_m) {
    const std::size_t number = waiting[--count];
    const Box& box = boxes_[number];
    if (squared_distance(box, place) >= least * least) continue;
    if (box.count > 0) {
      for (std::size_t i = box.first; i < box.first + box.count; ++i) {
        least = std::min(least, test::distance_to_triangle(place, triangles_[i]));
      }
      continue;
    }
    const std::size_t left = number + 1;
    const bool is_left_nearer =
        squared_distance(boxes_[left], place) < squared_distance(boxes_[box.right], place);
    waiting[count++] = is_left_nearer ? box.right : left;
    waiting[count++] = is_left_nearer ? left : box.right;
  }
  return least;
}

double farthest_m(const std::vector<Triangle>& from, const NearestSurface& to, double spacing_m) {
  double farthest = 0.0;
  for (const auto& [a, b, c] : from) {
    const double longest = std::max({length(b - a), length(c - b), length(a - c)});
    const int steps = static_cast<int>(std::ceil(longest / spacing_m));
    for (int i = 0; i < steps; ++i) {
      for (int k = 0; i + k < steps; ++k) {
        const tree::Point place = a + (static_cast<double>(i) / steps) * (b - a) +
                                  (static_cast<double>(k) / steps) * (c - a);
        const double distance = to.distance_m(place, farthest);
        farthest = std::max(farthest, distance);
      }
    }
  }
  return farthest;
}

}  // namespace silvafit::bench
