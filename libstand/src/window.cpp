// SPDX-License-Identifier: MIT
// Polygons by Boost.Geometry; its R-tree over the edges answers which of them is nearest.
#include "silvafit/stand/window.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/multi_polygon.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/geometries/segment.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <iterator>

#include "silvafit/base/error.hpp"

namespace silvafit::stand {
namespace {

namespace bg = boost::geometry;
using BoostPoint = bg::model::d2::point_xy<double>;
using BoostPolygon = bg::model::polygon<BoostPoint>;
using BoostRegion = bg::model::multi_polygon<BoostPolygon>;
using Edge = bg::model::segment<BoostPoint>;
using EdgeTree = bg::index::rtree<Edge, bg::index::quadratic<16>>;

BoostPolygon::ring_type ring_of(const std::vector<Point>& corners) {
  BoostPolygon::ring_type ring;
  for (const Point& corner : corners) {
    if (!std::isfinite(corner.x) || !std::isfinite(corner.y)) {
      throw GeometryError("a corner of the polygon is not finite");
    }
    ring.emplace_back(corner.x, corner.y);
  }
  return ring;
}

/// What a forester can do about Boost's verdict.
std::string trouble(bg::validity_failure_type failure, const std::string& reason) {
  switch (failure) {
    case bg::failure_few_points:
      return "a ring has fewer than three different corners";
    case bg::failure_wrong_topological_dimension:
      return "a ring has no area";
    case bg::failure_spikes:
      return "the boundary runs out and back along the same line";
    case bg::failure_self_intersections:
      return "the boundary crosses or touches itself (" + reason + ")";
    case bg::failure_wrong_orientation:
      // Rings were turned the right way: what has no right way is a bow tie.
      return "the boundary crosses or touches itself";
    case bg::failure_interior_rings_outside:
      return "a hole lies outside its polygon";
    case bg::failure_nested_interior_rings:
      return "a hole lies inside another hole";
    case bg::failure_disconnected_interior:
      return "holes cut the polygon into pieces";
    default:
      return reason;
  }
}

BoostPolygon valid_polygon(const Polygon& source) {
  BoostPolygon polygon;
  polygon.outer() = ring_of(source.outer);
  for (const std::vector<Point>& hole : source.holes) polygon.inners().push_back(ring_of(hole));
  bg::correct(polygon);
  bg::validity_failure_type failure = bg::no_failure;
  std::string reason;
  if (polygon.outer().size() < 4) {
    throw GeometryError("not a valid polygon: " + trouble(bg::failure_few_points, ""));
  }
  // Repeated corners are harmless, and common in drawn polygons.
  bg::unique(polygon);
  if (!bg::is_valid(polygon, failure)) {
    bg::is_valid(polygon, reason);
    throw GeometryError("not a valid polygon: " + trouble(failure, reason));
  }
  return polygon;
}

void append_edges(const BoostPolygon::ring_type& ring, std::vector<Edge>& edges) {
  for (std::size_t i = 1; i < ring.size(); ++i) edges.emplace_back(ring[i - 1], ring[i]);
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

/// Whether an edge crosses the ray from a point to the east. An end on the ray counts as above it
/// or not at all, so that a corner is crossed once.
bool crosses_ray(Point point, const Edge& edge) {
  const bool first_is_above = edge.first.y() > point.y;
  if (first_is_above == (edge.second.y() > point.y)) return false;
  const double share = (point.y - edge.first.y()) / (edge.second.y() - edge.first.y());
  return edge.first.x() + share * (edge.second.x() - edge.first.x()) > point.x;
}

}  // namespace

struct Window::Shape {
  BoostRegion region{};
  EdgeTree edges{};
  Point low{};
  Point high{};
  double area_m2 = 0.0;
};

Window::Window(const std::vector<Polygon>& polygons) {
  auto shape = std::make_shared<Shape>();
  for (const Polygon& polygon : polygons) {
    BoostRegion joined;
    bg::union_(shape->region, valid_polygon(polygon), joined);
    shape->region = std::move(joined);
  }
  if (shape->region.empty()) throw GeometryError("a window needs a polygon");
  std::vector<Edge> edges;
  for (const BoostPolygon& polygon : shape->region) {
    append_edges(polygon.outer(), edges);
    for (const auto& hole : polygon.inners()) append_edges(hole, edges);
  }
  shape->edges = EdgeTree(edges);
  const auto box = bg::return_envelope<bg::model::box<BoostPoint>>(shape->region);
  shape->low = {box.min_corner().x(), box.min_corner().y()};
  shape->high = {box.max_corner().x(), box.max_corner().y()};
  shape->area_m2 = bg::area(shape->region);
  shape_ = std::move(shape);
}

Window Window::rectangle(Point low, Point high) {
  return Window({{.outer = {low, {high.x, low.y}, high, {low.x, high.y}}}});
}

double Window::area_m2() const { return shape_->area_m2; }

bool Window::contains(Point point) const {
  if (!(point.x >= shape_->low.x && point.x <= shape_->high.x)) return false;
  // A ray to the east crosses the boundary an odd number of times if it starts inside.
  const bg::model::box<BoostPoint> ray({point.x, point.y}, {shape_->high.x, point.y});
  bool is_inside = false;
  for (auto edge = shape_->edges.qbegin(bg::index::intersects(ray)); edge != shape_->edges.qend();
       ++edge) {
    if (crosses_ray(point, *edge)) is_inside = !is_inside;
  }
  return is_inside || distance_to_boundary_m(point) == 0.0;
}

double Window::distance_to_boundary_m(Point point) const {
  const auto nearest = bg::index::nearest(BoostPoint(point.x, point.y), 1);
  return distance_m(point, *shape_->edges.qbegin(nearest));
}

Point Window::low() const { return shape_->low; }
Point Window::high() const { return shape_->high; }

}  // namespace silvafit::stand
