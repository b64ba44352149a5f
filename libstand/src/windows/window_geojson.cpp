// SPDX-License-Identifier: MIT
// Windows from GeoJSON (RFC 7946), except for the reference system: coordinates are meters.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/window.hpp"
#include "windows/window_files.hpp"

namespace silvafit::stand {
namespace {

using nlohmann::json;

class GeoJsonReader {
 public:
  explicit GeoJsonReader(const std::filesystem::path& path) : file_(path.string()) {}

  std::vector<NamedWindow> read();

 private:
  [[noreturn]] void fail(const std::string& message) const;
  json parse() const;
  void collect_feature(const json& feature, std::size_t number);
  void collect_circle(const json& feature, const std::string& where);
  std::optional<std::string> plot_of(const json& feature) const;
  std::vector<Polygon> polygons_of(const json& geometry, const std::string& where) const;
  Polygon polygon_of(const json& rings, const std::string& where) const;
  std::vector<Point> ring_of(const json& positions, const std::string& where) const;
  Point point_of(const json& position, const std::string& where) const;
  void add(const std::optional<std::string>& plot,
           const std::vector<Polygon>& polygons,
           const std::string& where);

  std::string file_;
  WindowCollector collector_{};
};

void GeoJsonReader::fail(const std::string& message) const {
  throw InputError(message, {.file = file_});
}

json GeoJsonReader::parse() const {
  const std::string text = text_of(file_);
  try {
    return json::parse(text);
  } catch (const json::parse_error& error) {
    const std::size_t read = std::min(error.byte, text.size());
    const auto line_ends =
        std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(read), '\n');
    throw InputError("not valid JSON from here",
                     {.file = file_, .line = static_cast<std::size_t>(line_ends) + 1});
  } catch (const json::out_of_range&) {
    fail("a number is too large");
  }
}

std::string type_of(const json& object) {
  if (!object.is_object()) return "";
  const auto type = object.find("type");
  return type != object.end() && type->is_string() ? type->get<std::string>() : "";
}

Point GeoJsonReader::point_of(const json& position, const std::string& where) const {
  const bool is_position = position.is_array() && position.size() >= 2 && position[0].is_number() &&
                           position[1].is_number();
  if (!is_position) fail(where + ": a position must be [x, y] in meters");
  return {position[0].get<double>(), position[1].get<double>()};
}

std::vector<Point> GeoJsonReader::ring_of(const json& positions, const std::string& where) const {
  if (!positions.is_array()) fail(where + ": a ring must be an array of positions");
  std::vector<Point> ring;
  for (const json& position : positions) ring.push_back(point_of(position, where));
  return ring;
}

Polygon GeoJsonReader::polygon_of(const json& rings, const std::string& where) const {
  if (!rings.is_array() || rings.empty()) fail(where + ": a polygon must be an array of rings");
  Polygon polygon{.outer = ring_of(rings[0], where)};
  for (std::size_t i = 1; i < rings.size(); ++i) polygon.holes.push_back(ring_of(rings[i], where));
  return polygon;
}

std::vector<Polygon> GeoJsonReader::polygons_of(const json& geometry,
                                                const std::string& where) const {
  const std::string type = type_of(geometry);
  if (type != "Polygon" && type != "MultiPolygon") {
    fail(fmt::format("{}: expected a Polygon or MultiPolygon{}",
                     where,
                     type.empty() ? "" : fmt::format(", not a {}", type)));
  }
  const auto coordinates = geometry.find("coordinates");
  if (coordinates == geometry.end() || !coordinates->is_array())
    fail(where + ": coordinates are missing");
  std::vector<Polygon> polygons;
  if (type == "Polygon") {
    polygons.push_back(polygon_of(*coordinates, where));
  } else {
    for (const json& rings : *coordinates) polygons.push_back(polygon_of(rings, where));
  }
  return polygons;
}

/// The feature's property `plot` as the text of a label.
std::optional<std::string> GeoJsonReader::plot_of(const json& feature) const {
  const auto properties = feature.find("properties");
  if (properties == feature.end() || !properties->is_object()) return std::nullopt;
  const auto plot = properties->find("plot");
  if (plot == properties->end() || plot->is_null()) return std::nullopt;
  if (plot->is_string()) return plot->get<std::string>();
  if (plot->is_number()) return data::shortest(plot->get<double>());
  fail("the property 'plot' of a feature must be a string or a number");
}

void GeoJsonReader::collect_feature(const json& feature, std::size_t number) {
  const std::string where = fmt::format("feature {}", number);
  if (type_of(feature) != "Feature") fail(where + ": the type must be Feature");
  const std::optional<std::string> plot = plot_of(feature);
  const json geometry = feature.value("geometry", json());
  if (type_of(geometry) == "Point") {
    collect_circle(feature, where);
  } else {
    add(plot, polygons_of(geometry, where), where);
  }
}

void GeoJsonReader::add(const std::optional<std::string>& plot,
                        const std::vector<Polygon>& polygons,
                        const std::string& where) {
  try {
    collector_.add(plot, polygons);
  } catch (const GeometryError& error) {
    fail(where + ": " + error.message());
  }
}

/// A circular plot: its center, and the property `radius`.
void GeoJsonReader::collect_circle(const json& feature, const std::string& where) {
  const auto properties = feature.find("properties");
  const bool has_radius = properties != feature.end() && properties->is_object() &&
                          properties->contains("radius") && (*properties)["radius"].is_number();
  if (!has_radius) fail(where + ": a Point needs the property 'radius' in meters");
  const json& geometry = feature["geometry"];
  const auto position = geometry.find("coordinates");
  if (position == geometry.end()) fail(where + ": coordinates are missing");
  const Point center = point_of(*position, where);
  try {
    collector_.add_circle(plot_of(feature), center, (*properties)["radius"].get<double>());
  } catch (const GeometryError& error) {
    fail(where + ": " + error.message());
  }
}

std::vector<NamedWindow> GeoJsonReader::read() {
  const json document = parse();
  const std::string type = type_of(document);
  if (type == "FeatureCollection") {
    const auto features = document.find("features");
    if (features == document.end() || !features->is_array()) fail("the collection has no features");
    std::size_t number = 0;
    for (const json& feature : *features) collect_feature(feature, ++number);
  } else if (type == "Feature") {
    collect_feature(document, 1);
  } else {
    add(std::nullopt, polygons_of(document, "the geometry"), "the geometry");
  }
  return collector_.windows(file_);
}

}  // namespace

std::vector<NamedWindow> read_geojson_windows(const std::filesystem::path& path) {
  return GeoJsonReader(path).read();
}

}  // namespace silvafit::stand
