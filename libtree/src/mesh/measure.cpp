// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {
namespace {

// The height of a vertex at 1.3 m in a mesh of floats.
constexpr double kBreastHeightInMesh = 1.3F;

struct Vertex {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

Vertex vertex_of(const MeshPart& part, std::size_t index) {
  const float* at = part.positions.data() + 3 * index;
  return {at[0], at[1], at[2]};
}

Vertex crossing(const Vertex& below, const Vertex& above, double height) {
  const double part = (height - below.y) / (above.y - below.y);
  return {below.x + part * (above.x - below.x), height, below.z + part * (above.z - below.z)};
}

/// Twice the signed area that one triangle adds to the section at a height (Green's
/// theorem).
double doubled_area(const std::array<Vertex, 3>& corners, double height) {
  std::array<Vertex, 2> ends{};  // where the outline enters and leaves the part below the plane
  int cuts = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vertex& from = corners[i];
    const Vertex& to = corners[(i + 1) % 3];
    const bool from_below = from.y < height;
    const bool to_below = to.y < height;
    if (from_below == to_below) continue;
    ends[from_below ? 1 : 0] = from_below ? crossing(from, to, height) : crossing(to, from, height);
    ++cuts;
  }
  return cuts == 2 ? ends[0].x * ends[1].z - ends[0].z * ends[1].x : 0.0;
}

/// Areas of the stem's sections at increasing heights.
std::vector<double> section_areas_m2(const Mesh& mesh, std::span<const double> heights) {
  std::vector<double> doubled(heights.size(), 0.0);
  for (const MeshPart& part : mesh.parts) {
    if (part.kind != PartKind::kStem) continue;
    for (std::size_t i = 0; i < part.indices.size(); i += 3) {
      const std::array<Vertex, 3> corners{vertex_of(part, part.indices[i]),
                                          vertex_of(part, part.indices[i + 1]),
                                          vertex_of(part, part.indices[i + 2])};
      const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
      const auto first = std::lower_bound(heights.begin(), heights.end(), low);
      for (auto at = first; at != heights.end() && *at <= high; ++at) {
        doubled[static_cast<std::size_t>(at - heights.begin())] += doubled_area(corners, *at);
      }
    }
  }
  for (double& area : doubled) area = 0.5 * std::abs(area);
  return doubled;
}

double diameter_cm(double area_m2) {
  constexpr double kCentimetersPerMeter = 100.0;
  return kCentimetersPerMeter * 2.0 * std::sqrt(area_m2 / std::numbers::pi);
}

/// The farthest vertices in the four directions.
class Reach {
 public:
  void add(const Vertex& v) {
    // tan(0.5 degrees)
    constexpr double kSector = 0.008726867790758789;
    if (std::abs(v.z) <= kSector * std::abs(v.x)) {
      widen(v.x > 0.0 ? radii_.east_m : radii_.west_m, v);
    } else if (std::abs(v.x) <= kSector * std::abs(v.z)) {
      widen(v.z > 0.0 ? radii_.south_m : radii_.north_m, v);
    }
  }
  const CrownRadii& radii() const { return radii_; }

 private:
  static void widen(double& radius, const Vertex& v) {
    radius = std::max(radius, std::hypot(v.x, v.z));
  }
  CrownRadii radii_{};
};

}  // namespace

Measurements measure_dead_wood(const Mesh& mesh) {
  Measurements measured{.h_m = 0.0, .hcb_m = kInfinity};
  Reach reach;
  for (const MeshPart& part : mesh.parts) {
    if (part.kind == PartKind::kAerialRoots) continue;
    for (std::size_t i = 0; i < part.vertex_count(); ++i) {
      const Vertex v = vertex_of(part, i);
      measured.h_m = std::max(measured.h_m, v.y);
      if (part.kind == PartKind::kStem) continue;
      measured.hcb_m = std::min(measured.hcb_m, v.y);
      reach.add(v);
    }
  }
  measured.hcb_m = std::min(measured.hcb_m, measured.h_m);
  measured.dbh_cm = diameter_cm(section_areas_m2(mesh, std::array{kBreastHeightInMesh}).front());
  measured.radii = reach.radii();
  measured.vertices = mesh.vertex_count();
  measured.triangles = mesh.triangle_count();
  return measured;
}

Measurements measure(const Mesh& mesh) {
  const Measurements measured = measure_dead_wood(mesh);
  if (!(measured.dbh_cm > 0.0)) throw GeometryError("the mesh has no stem at 1.3 m");
  const auto is_crown = [](const MeshPart& part) {
    return part.kind == PartKind::kBranches || part.kind == PartKind::kFoliage;
  };
  if (std::ranges::none_of(mesh.parts, is_crown)) throw GeometryError("the mesh has no crown");
  return measured;
}

std::vector<double> stem_diameters_cm(const Mesh& mesh, std::span<const double> heights_m) {
  std::vector<std::size_t> order(heights_m.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return heights_m[a] < heights_m[b];
  });
  std::vector<double> rising;
  rising.reserve(order.size());
  for (const std::size_t i : order) rising.push_back(heights_m[i]);
  const std::vector<double> areas = section_areas_m2(mesh, rising);
  std::vector<double> diameters(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) diameters[order[k]] = diameter_cm(areas[k]);
  return diameters;
}

}  // namespace silvafit::tree
