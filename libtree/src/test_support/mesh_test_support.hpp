// SPDX-License-Identifier: MIT
// Checks of a mesh of any builder.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::test {

/// A vertex in the tree's frame, z up.
inline tree::Point vertex_of(const tree::MeshPart& part, std::size_t i) {
  const float* at = part.positions.data() + 3 * i;
  return {at[0], -at[2], at[1]};
}

inline tree::Point normal_of(const tree::MeshPart& part, std::size_t i) {
  const float* at = part.normals.data() + 3 * i;
  return {at[0], -at[2], at[1]};
}

inline std::array<tree::Point, 3> triangle_of(const tree::MeshPart& part, std::size_t triangle) {
  return {vertex_of(part, part.indices[3 * triangle]),
          vertex_of(part, part.indices[3 * triangle + 1]),
          vertex_of(part, part.indices[3 * triangle + 2])};
}

/// Directed edges between positions, not between vertices: seams count as joined.
inline std::map<std::array<float, 6>, int> edges_of(const tree::MeshPart& part) {
  std::map<std::array<float, 6>, int> edges;
  const auto& p = part.positions;
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = std::size_t{3} * part.indices[i + j];
      const std::size_t b = std::size_t{3} * part.indices[i + (j + 1) % 3];
      ++edges[{p[a], p[a + 1], p[a + 2], p[b], p[b + 1], p[b + 2]}];
    }
  }
  return edges;
}

/// Edges that do not have equally many triangles in both directions. Two tubes may have an edge at
/// the same position.
inline std::size_t open_edges(const tree::MeshPart& part) {
  const auto edges = edges_of(part);
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge[3], edge[4], edge[5], edge[0], edge[1], edge[2]});
    if (back == edges.end() || back->second != count) ++open;
  }
  return open;
}

/// Edges between vertices that do not belong to exactly two triangles, one in each direction;
/// including seams.
inline std::size_t open_or_split_edges(const tree::MeshPart& part) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    for (std::size_t j = 0; j < 3; ++j)
      ++edges[{part.indices[i + j], part.indices[i + (j + 1) % 3]}];
  }
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end() || back->second != 1) ++open;
  }
  return open;
}

/// Twice the least area of a triangle [m2]; 0 if two corners of one have the same position.
inline double least_doubled_area(const tree::MeshPart& part) {
  double least = 1e9;
  for (std::size_t i = 0; i < part.triangle_count(); ++i) {
    const auto [a, b, c] = triangle_of(part, i);
    least = std::min(least, length(cross(b - a, c - a)));
  }
  return least;
}

/// Triangles whose face is opposite to the normals of their corners.
inline std::size_t turned_triangles(const tree::MeshPart& part) {
  std::size_t turned = 0;
  for (std::size_t i = 0; i < part.triangle_count(); ++i) {
    const auto [a, b, c] = triangle_of(part, i);
    const tree::Point sum = normal_of(part, part.indices[3 * i]) +
                            normal_of(part, part.indices[3 * i + 1]) +
                            normal_of(part, part.indices[3 * i + 2]);
    // Faces nearly parallel to their normals may round to either side: floats shift the corners
    // of a face a millimeter wide by about a thousandth of that.
    const tree::Point face = cross(b - a, c - a);
    if (dot(face, sum) < -0.01 * length(face)) ++turned;
  }
  return turned;
}

/// Volume of a closed part whose faces point outwards [m3].
inline double volume_m3(const tree::MeshPart& part) {
  double volume = 0.0;
  for (std::size_t i = 0; i < part.triangle_count(); ++i) {
    const auto [a, b, c] = triangle_of(part, i);
    volume += dot(a, cross(b, c)) / 6.0;
  }
  return volume;
}

/// Distance of a point from a triangle (Ericson 2005, Real-Time Collision Detection, 5.1.5: the
/// regions of the triangle's plane in which the nearest point is on a corner, an edge or the face).
inline double distance_to_triangle(tree::Point p, const std::array<tree::Point, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const tree::Point ab = b - a;
  const tree::Point ac = c - a;
  const double d1 = dot(ab, p - a);
  const double d2 = dot(ac, p - a);
  if (d1 <= 0.0 && d2 <= 0.0) return length(p - a);
  const double d3 = dot(ab, p - b);
  const double d4 = dot(ac, p - b);
  if (d3 >= 0.0 && d4 <= d3) return length(p - b);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return length(p - (a + (d1 / (d1 - d3)) * ab));
  const double d5 = dot(ab, p - c);
  const double d6 = dot(ac, p - c);
  if (d6 >= 0.0 && d5 <= d6) return length(p - c);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return length(p - (a + (d2 / (d2 - d6)) * ac));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
    return length(p - (b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b)));
  }
  const double sum = va + vb + vc;
  return length(p - (a + (vb / sum) * ab + (vc / sum) * ac));
}

/// The largest distance of stem and branches of `from` from those of `to`, at corners, the middles
/// of edges and the middles of faces [m].
inline double farthest_wood_m(const tree::Mesh& from, const tree::Mesh& to) {
  std::vector<std::array<tree::Point, 3>> surface;
  for (const tree::MeshPart& part : to.parts) {
    if (part.kind == tree::PartKind::kFoliage) continue;
    for (std::size_t i = 0; i < part.triangle_count(); ++i) surface.push_back(triangle_of(part, i));
  }
  double farthest = 0.0;
  std::size_t nearest = 0;  // to the point before: the next is close to it
  const auto look = [&](tree::Point p) {
    double least = 1e9;
    for (std::size_t step = 0, at = nearest; step < surface.size(); ++step, ++at) {
      if (at == surface.size()) at = 0;
      const auto& triangle = surface[at];
      // Triangles whose height range is farther than the nearest found so far cannot be nearer.
      const auto [low, high] = std::minmax({triangle[0].z, triangle[1].z, triangle[2].z});
      if (p.z < low - least || p.z > high + least) continue;
      const double distance = distance_to_triangle(p, triangle);
      if (distance >= least) continue;
      least = distance;
      nearest = at;
      if (least <= farthest) return;
    }
    farthest = least;
  };
  for (const tree::MeshPart& part : from.parts) {
    if (part.kind == tree::PartKind::kFoliage) continue;
    for (std::size_t i = 0; i < part.triangle_count(); ++i) {
      const auto [a, b, c] = triangle_of(part, i);
      look(a);
      look(0.5 * (a + b));
      look(1.0 / 3.0 * (a + b + c));
    }
  }
  return farthest;
}

}  // namespace silvafit::test
