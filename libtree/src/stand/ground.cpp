// SPDX-License-Identifier: MIT
#include "silvafit/tree/ground.hpp"

#include <algorithm>
#include <boost/polygon/voronoi.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {
namespace {

/// A stem base, or another point of the ground, in whole centimeters, as the diagram needs it.
struct Foot {
  std::int32_t east = 0;
  std::int32_t north = 0;
  double z_m = 0.0;
};

constexpr double kCentimetersPerMeter = 100.0;

std::int32_t centimeters(double meters) {
  const double value = std::round(kCentimetersPerMeter * meters);
  // The diagram's arithmetic has 32 bits; half of the range leaves space for the margin.
  if (!(std::abs(value) <= 1e9)) {
    throw GeometryError("the stems are too far apart for one ground surface");
  }
  return static_cast<std::int32_t>(value);
}

std::vector<Foot> feet_of(std::span<const Position> stems, const Position& origin) {
  std::vector<Foot> feet;
  feet.reserve(stems.size() + 4);
  for (const Position& stem : stems) {
    feet.push_back({centimeters(stem.x_m - origin.x_m),
                    centimeters(stem.y_m - origin.y_m),
                    stem.z_m - origin.z_m});
  }
  return feet;
}

/// The box around all stems.
struct Box {
  Foot low{};
  Foot high{};
};

Box box_around(const std::vector<Foot>& feet, double margin_m) {
  Box box{feet.front(), feet.front()};
  for (const Foot& foot : feet) {
    box.low.east = std::min(box.low.east, foot.east);
    box.low.north = std::min(box.low.north, foot.north);
    box.high.east = std::max(box.high.east, foot.east);
    box.high.north = std::max(box.high.north, foot.north);
  }
  const std::int32_t margin = std::max(centimeters(margin_m), 1);
  box.low.east -= margin;
  box.low.north -= margin;
  box.high.east += margin;
  box.high.north += margin;
  return box;
}

/// The cells of an axis of a terrain, in ascending order.
struct Cells {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t count() const { return end - begin; }
};

/// The known cells of a terrain within the box.
void add_terrain(const data::Raster& terrain,
                 const Box& box,
                 const Position& origin,
                 std::vector<Foot>& feet) {
  const auto cells_between = [](double first, double last, std::size_t cells) {
    const auto whole = [cells](double cell) {
      return static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(cells)));
    };
    const std::size_t begin = whole(std::ceil(first));
    return Cells{begin, std::max(begin, whole(std::floor(last) + 1.0))};
  };
  const double west = origin.x_m + box.low.east / kCentimetersPerMeter;
  const double east = origin.x_m + box.high.east / kCentimetersPerMeter;
  const double south = origin.y_m + box.low.north / kCentimetersPerMeter;
  const double north = origin.y_m + box.high.north / kCentimetersPerMeter;
  const Cells columns = cells_between((west - terrain.west) / terrain.step_x,
                                      (east - terrain.west) / terrain.step_x,
                                      terrain.columns);
  const Cells rows = cells_between((terrain.north - north) / terrain.step_y,
                                   (terrain.north - south) / terrain.step_y,
                                   terrain.rows);
  const double points = static_cast<double>(columns.count()) * static_cast<double>(rows.count());
  const auto every = static_cast<std::size_t>(
      std::max(1.0, std::ceil(std::sqrt(points / static_cast<double>(kMostGroundPoints)))));
  for (std::size_t row = rows.begin; row < rows.end; row += every) {
    for (std::size_t column = columns.begin; column < columns.end; column += every) {
      const double z_m = terrain.value(column, row);
      if (std::isnan(z_m)) continue;
      feet.push_back({centimeters(terrain.x_of(column) - origin.x_m),
                      centimeters(terrain.y_of(row) - origin.y_m),
                      z_m - origin.z_m});
    }
  }
}

/// The corners of the box, each as high as the terrain there, else as the nearest point.
void add_corners(const Box& box,
                 const Position& origin,
                 const data::Raster* terrain,
                 std::vector<Foot>& feet) {
  const std::size_t points = feet.size();
  for (const std::int32_t east : {box.low.east, box.high.east}) {
    for (const std::int32_t north : {box.low.north, box.high.north}) {
      const auto squared = [&](const Foot& foot) {
        const double dx = static_cast<double>(foot.east) - east;
        const double dy = static_cast<double>(foot.north) - north;
        return dx * dx + dy * dy;
      };
      const auto nearest =
          std::min_element(feet.begin(),
                           feet.begin() + static_cast<std::ptrdiff_t>(points),
                           [&](const Foot& a, const Foot& b) { return squared(a) < squared(b); });
      const double known_m = terrain == nullptr
                                 ? std::numeric_limits<double>::quiet_NaN()
                                 : terrain->at(origin.x_m + east / kCentimetersPerMeter,
                                               origin.y_m + north / kCentimetersPerMeter);
      feet.push_back({east, north, std::isnan(known_m) ? nearest->z_m : known_m - origin.z_m});
    }
  }
}

/// In a fixed order, one point per position: the lowest of those that share it.
void make_unique(std::vector<Foot>& feet) {
  const auto key = [](const Foot& foot) { return std::tie(foot.east, foot.north, foot.z_m); };
  std::sort(
      feet.begin(), feet.end(), [&](const Foot& a, const Foot& b) { return key(a) < key(b); });
  feet.erase(std::unique(feet.begin(),
                         feet.end(),
                         [](const Foot& a, const Foot& b) {
                           return a.east == b.east && a.north == b.north;
                         }),
             feet.end());
}

/// Triangles of the dual of the Voronoi diagram; cells around a corner with more than three become
/// a fan.
std::vector<std::uint32_t> triangles_of(const std::vector<Foot>& feet) {
  std::vector<boost::polygon::point_data<std::int32_t>> points;
  points.reserve(feet.size());
  for (const Foot& foot : feet) points.emplace_back(foot.east, foot.north);
  boost::polygon::voronoi_diagram<double> diagram;
  boost::polygon::construct_voronoi(points.begin(), points.end(), &diagram);
  std::vector<std::uint32_t> indices;
  for (const auto& corner : diagram.vertices()) {
    std::vector<std::uint32_t> around;
    const auto* edge = corner.incident_edge();
    do {
      around.push_back(static_cast<std::uint32_t>(edge->cell()->source_index()));
      edge = edge->rot_next();
    } while (edge != corner.incident_edge());
    for (std::size_t i = 2; i < around.size(); ++i) {
      std::uint32_t a = around[0];
      std::uint32_t b = around[i - 1];
      std::uint32_t c = around[i];
      const double area = (static_cast<double>(feet[b].east) - feet[a].east) *
                              (static_cast<double>(feet[c].north) - feet[a].north) -
                          (static_cast<double>(feet[c].east) - feet[a].east) *
                              (static_cast<double>(feet[b].north) - feet[a].north);
      if (area == 0.0) continue;
      // Counterclockwise as seen from above.
      if (area < 0.0) std::swap(b, c);
      indices.insert(indices.end(), {a, b, c});
    }
  }
  return indices;
}

void add_normals(MeshPart& part) {
  const std::size_t vertices = part.vertex_count();
  std::vector<Point> sums(vertices);
  const auto at = [&part](std::uint32_t i) {
    const float* p = part.positions.data() + 3 * std::size_t{i};
    return Point{p[0], p[1], p[2]};
  };
  for (std::size_t i = 0; i < part.indices.size(); i += 3) {
    const Point a = at(part.indices[i]);
    const Point face = cross(at(part.indices[i + 1]) - a, at(part.indices[i + 2]) - a);
    for (std::size_t k = 0; k < 3; ++k) {
      Point& sum = sums[part.indices[i + k]];
      sum = sum + face;
    }
  }
  for (const Point& sum : sums) {
    const Point normal = direction(sum, {0.0, 1.0, 0.0});
    part.normals.push_back(static_cast<float>(normal.x));
    part.normals.push_back(static_cast<float>(normal.y));
    part.normals.push_back(static_cast<float>(normal.z));
  }
}

}  // namespace

MeshPart ground_mesh(std::span<const Position> stems,
                     const Position& origin,
                     double margin_m,
                     const data::Raster* terrain) {
  if (stems.empty()) throw GeometryError("a ground needs at least one stem");
  std::vector<Foot> feet = feet_of(stems, origin);
  const Box box = box_around(feet, margin_m);
  if (terrain != nullptr) add_terrain(*terrain, box, origin, feet);
  make_unique(feet);
  add_corners(box, origin, terrain, feet);
  make_unique(feet);
  MeshPart part{.kind = PartKind::kStem, .color = {0.07, 0.055, 0.035}, .double_sided = true};
  for (const Foot& foot : feet) {
    part.positions.push_back(static_cast<float>(foot.east / kCentimetersPerMeter));
    part.positions.push_back(static_cast<float>(foot.z_m));
    part.positions.push_back(static_cast<float>(-foot.north / kCentimetersPerMeter) + 0.0F);
  }
  part.indices = triangles_of(feet);
  add_normals(part);
  return part;
}

}  // namespace silvafit::tree
