// SPDX-License-Identifier: MIT
// Windows: the inventoried area, and the distance of trees from its boundary.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::stand {

struct Point {
  double x = 0.0;  ///< east [m]
  double y = 0.0;  ///< north [m]
};

/// A polygon: an outer ring and holes, each a list of at least three vertices in either direction;
/// the last vertex may repeat the first.
struct Polygon {
  std::vector<Point> outer{};
  std::vector<std::vector<Point>> holes{};
};

/// One or more polygons, concave or with holes, that do not overlap; or a circle. Immutable and
/// cheap to copy.
class Window {
 public:
  /// \throws GeometryError if a ring is not a valid polygon (crosses itself, has no area, a hole
  ///         outside, ...); the message gives the reason
  explicit Window(const std::vector<Polygon>& polygons);

  /// The rectangle between two corners; low.x < high.x and low.y < high.y.
  static Window rectangle(Point low, Point high);

  /// A circular plot. Distances and areas are those of the circle, not of a polygon near it.
  /// \throws GeometryError unless the center is finite and the radius above 0
  static Window circle(Point center, double radius_m);

  /// The convex hull of points; none if they all lie on one line (within 1e-6 m).
  static std::optional<Window> convex_hull(std::span<const Point> points);

  double area_m2() const;
  /// Length of the boundary, holes included.
  double perimeter_m() const;
  /// The largest effect of rounding on a point near the window [m]: 1e-9, or more if coordinates
  /// are in the millions.
  double rounding_m() const;
  /// Inside or on the boundary, with tolerance rounding_m(). Cost: logarithmic in the number of
  /// vertices, as for the next function.
  bool contains(Point point) const;
  /// Distance to the nearest point of the boundary, holes included [m]; >= 0 on either side.
  double distance_to_boundary_m(Point point) const;
  /// Area of the points of the window that are at least this far from its boundary [m2].
  /// Closed form for axis-parallel rectangles and circles; else by Boost's polygon buffer, whose
  /// arcs at inner corners have 360 vertices per circle (their area is 5e-5 too small).
  double eroded_area_m2(double distance_m) const;
  /// Area shared with another window [m2], circles as polygons.
  double shared_area_m2(const Window& other) const;
  /// Whether it is a rectangle with sides parallel to x and y, with tolerance rounding_m().
  bool is_rectangle() const;
  /// The polygons as lists of vertices; a circle as a polygon of 120 vertices. For drawing.
  std::vector<Polygon> outline() const;
  Point low() const;   ///< south-west corner of the bounding rectangle
  Point high() const;  ///< north-east corner of the bounding rectangle

  /// Whether two are the same window object, not merely equal ones.
  bool is_same(const Window& other) const { return shape_ == other.shape_; }

 private:
  struct Shape;
  explicit Window(std::shared_ptr<const Shape> shape) : shape_(std::move(shape)) {}
  std::shared_ptr<const Shape> shape_;
};

/// The name of a window that applies to every plot, each in its own coordinates.
inline constexpr char kEveryPlot[] = "*";

/// A window of the whole stand (no plot), of the named plot, or of every plot (kEveryPlot).
struct NamedWindow {
  std::optional<std::string> plot{};
  Window window;
};

/// Reads windows from a file, with coordinates in meters as in the inventory.
///
/// GeoJSON: a Feature or FeatureCollection of Polygon or MultiPolygon, or of Point with the
/// property `radius` [m], or a bare polygon geometry. A feature's property `plot` names the plot of
/// the window. WKT: POLYGON and MULTIPOLYGON, each on a new line, all for the stand. CSV: the
/// columns plot and wkt, or plot, x, y and radius of circular plots, or plot, x and y of the
/// corners of plots in order; without plot, for the stand. Polygons of one plot, and those of none,
/// are combined; a plot has at most one circle. \throws InputError if the file is none of these, or
/// a polygon is not valid
std::vector<NamedWindow> read_windows(const std::filesystem::path& path);

/// Windows of a table with the columns of such a CSV file; plots may have another usual name.
/// \throws as read_windows
std::vector<NamedWindow> windows_of_table(const data::TableSource& table);

}  // namespace silvafit::stand
