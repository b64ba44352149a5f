// SPDX-License-Identifier: MIT
// Polygons by Boost.Geometry; its R-tree over the edges finds the nearest edge.
#include "silvafit/stand/window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/multi_point.hpp>
#include <boost/geometry/geometries/multi_polygon.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/geometries/segment.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "windows/coordinate_rounding.hpp"

namespace silvafit::stand {
namespace {

namespace bg = boost::geometry;
using BoostPoint = bg::model::d2::point_xy<double>;
using BoostPolygon = bg::model::polygon<BoostPoint>;
using BoostRegion = bg::model::multi_polygon<BoostPolygon>;
using Edge = bg::model::segment<BoostPoint>;
using EdgeTree = bg::index::rtree<Edge, bg::index::quadratic<16>>;

/// Up to this number, edges are searched one by one, which is faster than the R-tree.
constexpr std::size_t kFewEdges = 64;
/// Rounding of coordinates near the origin.
constexpr double kRoundingMeters = 1e-9;
/// Larger coordinates are stored relative to the window's first vertex: products of areas and
/// intersections would lose half their digits at the millions of meters of national grids.
constexpr double kFarMeters = 1e4;
/// A hull this narrow is a line: coordinates in a national grid are rounded to 2e-9 m.
constexpr double kThinnestMeters = 1e-6;
constexpr std::size_t kCornersOfOutline = 120;
constexpr std::size_t kCornersOfArc = 360;

Point operator-(Point left, Point right) { return {left.x - right.x, left.y - right.y}; }
Point operator+(Point left, Point right) { return {left.x + right.x, left.y + right.y}; }

/// Origin of the stored coordinates: whole meters, so that no digit is lost.
Point origin_near(Point corner) {
  const auto whole = [](double value) {
    return std::abs(value) > kFarMeters ? std::floor(value) : 0.0;
  };
  return {whole(corner.x), whole(corner.y)};
}

BoostPolygon::ring_type ring_of(const std::vector<Point>& corners, Point origin) {
  BoostPolygon::ring_type ring;
  for (const Point& corner : corners) {
    if (!std::isfinite(corner.x) || !std::isfinite(corner.y)) {
      throw GeometryError("a vertex of the polygon is not finite");
    }
    const Point local = corner - origin;
    ring.emplace_back(local.x, local.y);
  }
  return ring;
}

/// The error of Boost in terms of the correction that is needed.
std::string trouble(bg::validity_failure_type failure, const std::string& reason) {
  switch (failure) {
    case bg::failure_few_points:
      return "a ring has fewer than three different vertices";
    case bg::failure_wrong_topological_dimension:
      return "a ring has no area";
    case bg::failure_spikes:
      return "the boundary returns along the same line";
    case bg::failure_self_intersections:
      // "... A self-intersection point was found at (1, 2); method: i; ..."
      if (const std::size_t at = reason.find(" at ("); at != std::string::npos) {
        return "the boundary crosses or touches itself" +
               reason.substr(at, reason.find(';', at) - at);
      }
      [[fallthrough]];
    case bg::failure_wrong_orientation:
      // Rings have been oriented; a ring that cannot be oriented is a bow tie.
      return "the boundary crosses or touches itself";
    case bg::failure_interior_rings_outside:
      return "a hole is outside its polygon";
    case bg::failure_nested_interior_rings:
      return "a hole is inside another hole";
    case bg::failure_disconnected_interior:
      return "holes divide the polygon into pieces";
    default:
      return reason;
  }
}

BoostPolygon valid_polygon(const Polygon& source, Point origin) {
  BoostPolygon polygon;
  polygon.outer() = ring_of(source.outer, origin);
  for (const std::vector<Point>& hole : source.holes) {
    polygon.inners().push_back(ring_of(hole, origin));
  }
  bg::correct(polygon);
  bg::validity_failure_type failure = bg::no_failure;
  std::string reason;
  if (polygon.outer().size() < 4) {
    throw GeometryError("not a valid polygon: " + trouble(bg::failure_few_points, ""));
  }
  // Repeated vertices are harmless, and common in digitized polygons.
  bg::unique(polygon);
  if (!bg::is_valid(polygon, failure)) {
    bg::is_valid(polygon, reason);
    throw GeometryError("not a valid polygon: " + trouble(failure, reason));
  }
  return polygon;
}

void append_edges(const BoostPolygon::ring_type& ring, std::vector<Edge>& edges) {
  for (std::size_t i = 1; i < ring.size(); ++i) {
    const bool has_length = ring[i].x() != ring[i - 1].x() || ring[i].y() != ring[i - 1].y();
    if (has_length) edges.emplace_back(ring[i - 1], ring[i]);
  }
}

/// Distance from a point to an edge. Where the foot of the perpendicular lies on the edge it is
/// |cross product| / length, which is exact for edges along an axis.
double distance_m(Point point, const Edge& edge) {
  const double along_x = edge.second.x() - edge.first.x();
  const double along_y = edge.second.y() - edge.first.y();
  const double from_x = point.x - edge.first.x();
  const double from_y = point.y - edge.first.y();
  const double length_squared = along_x * along_x + along_y * along_y;
  const double projection = from_x * along_x + from_y * along_y;
  if (projection <= 0.0) return std::hypot(from_x, from_y);
  if (projection >= length_squared) {
    return std::hypot(point.x - edge.second.x(), point.y - edge.second.y());
  }
  return std::abs(along_x * from_y - along_y * from_x) / std::sqrt(length_squared);
}

/// Square of the distance from a point to an edge, fast and accurate enough to find the nearest.
double squared_distance_m2(Point point, const Edge& edge) {
  const double along_x = edge.second.x() - edge.first.x();
  const double along_y = edge.second.y() - edge.first.y();
  const double from_x = point.x - edge.first.x();
  const double from_y = point.y - edge.first.y();
  const double share = std::clamp(
      (from_x * along_x + from_y * along_y) / (along_x * along_x + along_y * along_y), 0.0, 1.0);
  const double off_x = from_x - share * along_x;
  const double off_y = from_y - share * along_y;
  return off_x * off_x + off_y * off_y;
}

/// Whether an edge crosses the ray from a point to the east. An end on the ray counts as above it
/// or not at all, so that a corner is crossed once.
bool crosses_ray(Point point, const Edge& edge) {
  const bool first_is_above = edge.first.y() > point.y;
  if (first_is_above == (edge.second.y() > point.y)) return false;
  const double share = (point.y - edge.first.y()) / (edge.second.y() - edge.first.y());
  return edge.first.x() + share * (edge.second.x() - edge.first.x()) > point.x;
}

struct Circle {
  Point center{};
  double radius_m = 0.0;

  double from_center_m(Point point) const {
    return std::hypot(point.x - center.x, point.y - center.y);
  }
};

}  // namespace

struct Window::Shape {
  std::optional<Circle> circle{};  ///< instead of a region with edges
  Point origin{};                  ///< origin of the coordinates of region and edges
  BoostRegion region{};
  std::vector<Edge> edge_list{};
  std::optional<EdgeTree> edges{};  ///< only with more than a few edges
  Point low{};
  Point high{};
  double rounding_m = kRoundingMeters;
  double area_m2 = 0.0;
  double perimeter_m = 0.0;
  bool is_rectangle = false;

  void complete();
  void set_rounding();
  bool has_sides_of_box() const;
};

/// Values computed from the region.
void Window::Shape::complete() {
  for (const BoostPolygon& polygon : region) {
    append_edges(polygon.outer(), edge_list);
    for (const auto& hole : polygon.inners()) append_edges(hole, edge_list);
  }
  edge_list.shrink_to_fit();
  if (edge_list.size() > kFewEdges) edges.emplace(edge_list);
  const auto box = bg::return_envelope<bg::model::box<BoostPoint>>(region);
  low = origin + Point{box.min_corner().x(), box.min_corner().y()};
  high = origin + Point{box.max_corner().x(), box.max_corner().y()};
  set_rounding();
  area_m2 = bg::area(region);
  perimeter_m = static_cast<double>(bg::perimeter(region));
  is_rectangle = has_sides_of_box();
}

void Window::Shape::set_rounding() {
  const double farthest =
      std::max({std::abs(low.x), std::abs(low.y), std::abs(high.x), std::abs(high.y)});
  rounding_m = std::max(kRoundingMeters, coordinate_rounding_m(farthest));
}

/// Whether every edge is on a side of the bounding rectangle.
bool Window::Shape::has_sides_of_box() const {
  const Point local_low = low - origin;
  const Point local_high = high - origin;
  const auto is_at = [this](double value, double side) {
    return std::abs(value - side) <= rounding_m;
  };
  return std::ranges::all_of(edge_list, [&](const Edge& edge) {
    const auto both_at = [&](double first, double second, double side) {
      return is_at(first, side) && is_at(second, side);
    };
    return both_at(edge.first.x(), edge.second.x(), local_low.x) ||
           both_at(edge.first.x(), edge.second.x(), local_high.x) ||
           both_at(edge.first.y(), edge.second.y(), local_low.y) ||
           both_at(edge.first.y(), edge.second.y(), local_high.y);
  });
}

Window::Window(const std::vector<Polygon>& polygons) {
  auto shape = std::make_shared<Shape>();
  for (const Polygon& polygon : polygons) {
    if (shape->region.empty() && !polygon.outer.empty()) {
      shape->origin = origin_near(polygon.outer.front());
    }
    BoostRegion joined;
    bg::union_(shape->region, valid_polygon(polygon, shape->origin), joined);
    shape->region = std::move(joined);
  }
  if (shape->region.empty()) throw GeometryError("a window needs at least one polygon");
  shape->complete();
  shape_ = std::move(shape);
}

Window Window::rectangle(Point low, Point high) {
  return Window({{.outer = {low, {high.x, low.y}, high, {low.x, high.y}}}});
}

Window Window::circle(Point center, double radius_m) {
  const bool is_finite =
      std::isfinite(center.x) && std::isfinite(center.y) && std::isfinite(radius_m);
  if (!is_finite || !(radius_m > 0.0)) {
    throw GeometryError(
        fmt::format("the circle around ({}, {}) with radius {} m is not a valid window",
                    center.x,
                    center.y,
                    radius_m));
  }
  auto shape = std::make_shared<Shape>();
  shape->circle = Circle{.center = center, .radius_m = radius_m};
  shape->low = {center.x - radius_m, center.y - radius_m};
  shape->high = {center.x + radius_m, center.y + radius_m};
  shape->set_rounding();
  shape->area_m2 = std::numbers::pi * radius_m * radius_m;
  shape->perimeter_m = 2.0 * std::numbers::pi * radius_m;
  return Window(std::shared_ptr<const Shape>(std::move(shape)));
}

std::optional<Window> Window::convex_hull(std::span<const Point> points) {
  if (points.empty()) return std::nullopt;
  auto shape = std::make_shared<Shape>();
  shape->origin = origin_near(points.front());
  bg::model::multi_point<BoostPoint> cloud;
  cloud.reserve(points.size());
  for (const Point& point : points) {
    const Point local = point - shape->origin;
    cloud.emplace_back(local.x, local.y);
  }
  BoostPolygon hull;
  bg::convex_hull(cloud, hull);
  // For a thin hull, half the perimeter is its length.
  const double thinnest_m2 = kThinnestMeters * static_cast<double>(bg::perimeter(hull)) / 2.0;
  if (hull.outer().size() < 4 || !(bg::area(hull) > thinnest_m2)) return std::nullopt;
  shape->region.push_back(std::move(hull));
  shape->complete();
  return Window(std::shared_ptr<const Shape>(std::move(shape)));
}

double Window::area_m2() const { return shape_->area_m2; }
double Window::perimeter_m() const { return shape_->perimeter_m; }
double Window::rounding_m() const { return shape_->rounding_m; }
bool Window::is_rectangle() const { return shape_->is_rectangle; }

bool Window::contains(Point point) const {
  const double rounding_m = shape_->rounding_m;
  if (shape_->circle) {
    return shape_->circle->from_center_m(point) <= shape_->circle->radius_m + rounding_m;
  }
  const bool is_between =
      point.x >= shape_->low.x - rounding_m && point.x <= shape_->high.x + rounding_m &&
      point.y >= shape_->low.y - rounding_m && point.y <= shape_->high.y + rounding_m;
  if (!is_between) return false;
  const Point local = point - shape_->origin;
  // A ray to the east crosses the boundary an odd number of times if it starts inside.
  bool is_inside = false;
  const auto count = [&](const Edge& edge) {
    if (crosses_ray(local, edge)) is_inside = !is_inside;
  };
  if (!shape_->edges) {
    for (const Edge& edge : shape_->edge_list) count(edge);
  } else {
    // Beyond the farthest vertex, and always after its start.
    const double end = shape_->high.x - shape_->origin.x + 2.0 * rounding_m;
    const bg::model::box<BoostPoint> ray({local.x, local.y}, {end, local.y});
    for (auto edge = shape_->edges->qbegin(bg::index::intersects(ray));
         edge != shape_->edges->qend();
         ++edge) {
      count(*edge);
    }
  }
  return is_inside || distance_to_boundary_m(point) <= rounding_m;
}

double Window::distance_to_boundary_m(Point point) const {
  if (shape_->circle) {
    return std::abs(shape_->circle->radius_m - shape_->circle->from_center_m(point));
  }
  const Point local = point - shape_->origin;
  if (!shape_->edges) {
    const auto nearest_edge =
        std::ranges::min_element(shape_->edge_list, {}, [local](const Edge& edge) {
          return squared_distance_m2(local, edge);
        });
    return distance_m(local, *nearest_edge);
  }
  const auto nearest = bg::index::nearest(BoostPoint(local.x, local.y), 1);
  return distance_m(local, *shape_->edges->qbegin(nearest));
}

double Window::eroded_area_m2(double distance_m) const {
  if (!(distance_m > 0.0)) return shape_->area_m2;
  if (shape_->circle) {
    const double radius = std::max(0.0, shape_->circle->radius_m - distance_m);
    return std::numbers::pi * radius * radius;
  }
  if (shape_->is_rectangle) {
    const double width = shape_->high.x - shape_->low.x - 2.0 * distance_m;
    const double height = shape_->high.y - shape_->low.y - 2.0 * distance_m;
    return std::max(0.0, width) * std::max(0.0, height);
  }
  namespace buffer = bg::strategy::buffer;
  BoostRegion eroded;
  bg::buffer(shape_->region,
             eroded,
             buffer::distance_symmetric<double>(-distance_m),
             buffer::side_straight(),
             buffer::join_round(kCornersOfArc),
             buffer::end_flat(),
             buffer::point_circle(kCornersOfArc));
  return bg::area(eroded);
}

double Window::shared_area_m2(const Window& other) const {
  const auto region_of = [this](const Window& window) {
    BoostRegion region;
    for (const Polygon& polygon : window.outline()) {
      BoostPolygon part;
      part.outer() = ring_of(polygon.outer, shape_->origin);
      for (const auto& hole : polygon.holes) {
        part.inners().push_back(ring_of(hole, shape_->origin));
      }
      bg::correct(part);
      region.push_back(std::move(part));
    }
    return region;
  };
  BoostRegion shared;
  bg::intersection(region_of(*this), region_of(other), shared);
  return bg::area(shared);
}

std::vector<Polygon> Window::outline() const {
  std::vector<Polygon> polygons;
  if (shape_->circle) {
    Polygon& polygon = polygons.emplace_back();
    for (std::size_t i = 0; i < kCornersOfOutline; ++i) {
      const double azimuth = 2.0 * std::numbers::pi * static_cast<double>(i) / kCornersOfOutline;
      polygon.outer.push_back(
          {shape_->circle->center.x + shape_->circle->radius_m * std::sin(azimuth),
           shape_->circle->center.y + shape_->circle->radius_m * std::cos(azimuth)});
    }
    return polygons;
  }
  const auto corners_of = [this](const BoostPolygon::ring_type& ring) {
    std::vector<Point> corners;
    for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
      corners.push_back(shape_->origin + Point{ring[i].x(), ring[i].y()});
    }
    return corners;
  };
  for (const BoostPolygon& source : shape_->region) {
    Polygon& polygon = polygons.emplace_back(Polygon{.outer = corners_of(source.outer())});
    for (const auto& hole : source.inners()) polygon.holes.push_back(corners_of(hole));
  }
  return polygons;
}

Point Window::low() const { return shape_->low; }
Point Window::high() const { return shape_->high; }

}  // namespace silvafit::stand
