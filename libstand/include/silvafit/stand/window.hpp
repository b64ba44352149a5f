// SPDX-License-Identifier: MIT
// Windows: the area that was inventoried, as polygons, and how far trees stand from its boundary.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace silvafit::stand {

struct Point {
  double x = 0.0;  ///< east [m]
  double y = 0.0;  ///< north [m]
};

/// A polygon: an outer ring and holes, each a list of at least three corners in either direction;
/// the last corner may repeat the first.
struct Polygon {
  std::vector<Point> outer{};
  std::vector<std::vector<Point>> holes{};
};

/// One or more polygons, concave or with holes, that do not overlap. Immutable and cheap to copy.
class Window {
 public:
  /// \throws GeometryError if a ring is no valid polygon (crosses itself, has no area, a hole
  ///         outside, ...); the message names the ring's trouble
  explicit Window(const std::vector<Polygon>& polygons);

  /// The rectangle between two corners; low.x < high.x and low.y < high.y.
  static Window rectangle(Point low, Point high);

  double area_m2() const;
  /// Inside or on the boundary. Cost: logarithmic in the number of corners, and so is the next.
  bool contains(Point point) const;
  /// Distance to the nearest point of the boundary, holes included [m]; >= 0 on either side.
  double distance_to_boundary_m(Point point) const;
  Point low() const;   ///< south-west corner of the bounding rectangle
  Point high() const;  ///< north-east corner of the bounding rectangle

 private:
  struct Shape;
  std::shared_ptr<const Shape> shape_;
};

/// A window of the whole stand, or of the plot that it names.
struct NamedWindow {
  std::optional<std::string> plot{};
  Window window;
};

/// Reads windows from GeoJSON: a Feature or FeatureCollection of Polygon or MultiPolygon, or a bare
/// geometry, with coordinates in metres as in the inventory. A feature's property `plot` says whose
/// window it is; features of one plot, and those of none, are joined.
/// \throws InputError if the file is no such GeoJSON, or a polygon is not valid
std::vector<NamedWindow> read_windows(const std::filesystem::path& path);

}  // namespace silvafit::stand
