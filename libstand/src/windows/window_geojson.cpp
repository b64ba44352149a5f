// SPDX-License-Identifier: MIT
// Windows from GeoJSON (RFC 7946), except for the reference system: coordinates are meters.
#include <fmt/format.h>

#include "silvafit/base/error.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/stand/window.hpp"
#include "windows/window_files.hpp"

namespace silvafit::stand {
namespace {

using data::JsonReader;

/// Empty if it has none.
std::string type_of(const JsonReader& object) {
  return object.has("type") ? object.at("type").any_text() : "";
}

Point point_of(const JsonReader& position) {
  const std::vector<double> numbers = position.numbers();
  if (numbers.size() < 2) position.fail("a position must be [x, y] in meters");
  return {numbers[0], numbers[1]};
}

Polygon polygon_of(const JsonReader& rings) {
  std::vector<std::vector<Point>> corners;
  for (const JsonReader& ring : rings.items()) {
    std::vector<Point>& own = corners.emplace_back();
    for (const JsonReader& position : ring.items()) own.push_back(point_of(position));
  }
  if (corners.empty()) rings.fail("a polygon must be an array of rings");
  return {.outer = corners.front(), .holes = {corners.begin() + 1, corners.end()}};
}

std::vector<Polygon> polygons_of(const JsonReader& geometry) {
  const std::string type = type_of(geometry);
  if (type == "Polygon") return {polygon_of(geometry.at("coordinates"))};
  if (type != "MultiPolygon") {
    geometry.fail(fmt::format("expected a Polygon or MultiPolygon{}",
                              type.empty() ? "" : fmt::format(", not a {}", type)));
  }
  std::vector<Polygon> polygons;
  for (const JsonReader& rings : geometry.at("coordinates").items()) {
    polygons.push_back(polygon_of(rings));
  }
  return polygons;
}

/// A property of a feature; none if it is missing or null.
std::optional<JsonReader> property(const JsonReader& feature, std::string_view name) {
  if (!feature.has("properties") || !feature.at("properties").has(name)) return std::nullopt;
  JsonReader value = feature.at("properties").at(name);
  return value.is_null() ? std::nullopt : std::optional(std::move(value));
}

/// Adds the window of a feature: polygons, or a circle around a point.
void add_feature(const JsonReader& feature, WindowCollector& windows) {
  if (type_of(feature) != "Feature") feature.fail("the type must be Feature");
  const std::optional<JsonReader> label = property(feature, "plot");
  const std::optional<std::string> plot = label ? std::optional(label->label()) : std::nullopt;
  const JsonReader geometry = feature.at("geometry");
  try {
    if (type_of(geometry) != "Point") return windows.add(plot, polygons_of(geometry));
    const std::optional<JsonReader> radius = property(feature, "radius");
    if (!radius) feature.fail("a Point needs the property 'radius' in meters");
    windows.add_circle(plot, point_of(geometry.at("coordinates")), radius->number());
  } catch (const GeometryError& error) {
    feature.fail(error.message());
  }
}

/// The member crs of older GeoJSON, as QGIS and GDAL write it.
void refuse_degrees(const JsonReader& document) {
  if (!document.is_object()) return;
  const auto system = document.find("crs");
  if (!system || system->is_null() || !system->has("properties")) return;
  const auto name = system->at("properties").find("name");
  if (!name || name->is_null()) return;
  const std::string text = name->text();
  for (const std::string_view geographic : {"CRS84", "::4326", ":4326", "::4258", ":4258"}) {
    if (!text.ends_with(geographic)) continue;
    name->fail(
        "the coordinates are degrees, but windows have the meters of the positions of "
        "trees; save the layer in their projected system");
  }
}

}  // namespace

std::vector<NamedWindow> read_geojson_windows(const std::filesystem::path& path) {
  const JsonReader document = JsonReader::parse(text_of(path), path.string());
  WindowCollector windows;
  refuse_degrees(document);
  const std::string type = type_of(document);
  if (type == "FeatureCollection") {
    for (const JsonReader& feature : document.at("features").items()) {
      add_feature(feature, windows);
    }
  } else if (type == "Feature") {
    add_feature(document, windows);
  } else {
    try {
      windows.add(std::nullopt, polygons_of(document));
    } catch (const GeometryError& error) {
      document.fail(error.message());
    }
  }
  return windows.windows(path.string());
}

}  // namespace silvafit::stand
