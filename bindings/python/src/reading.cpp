// SPDX-License-Identifier: MIT
#include "reading.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "tables.hpp"

namespace silvafit::python {
namespace {

using Ring = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<stand::Point> points_of(const Ring& ring) {
  const auto values = ring.unchecked<2>();
  std::vector<stand::Point> points;
  for (py::ssize_t i = 0; i < values.shape(0); ++i) points.push_back({values(i, 0), values(i, 1)});
  return points;
}

stand::Polygon polygon_of(const std::vector<Ring>& rings) {
  stand::Polygon polygon{.outer = points_of(rings.at(0))};
  for (std::size_t k = 1; k < rings.size(); ++k) polygon.holes.push_back(points_of(rings[k]));
  return polygon;
}

}  // namespace

study::ReadingSettings take_reading(Arguments& arguments) {
  study::ReadingSettings reading;
  std::map<std::string, std::string> columns;
  arguments.take("columns", columns);
  for (const auto& [name, source] : columns) reading.columns.push_back(name + "=" + source);
  arguments.take("trust_units", reading.trust_units);
  arguments.take("missing", reading.missing);
  arguments.take("fill_down", reading.fill_down);
  arguments.take("dead", reading.dead);
  arguments.take("alive_codes", reading.alive_codes);
  arguments.take("dead_codes", reading.dead_codes);
  arguments.take("cut_codes", reading.cut_codes);
  arguments.take("case_sensitive", reading.case_sensitive);
  return reading;
}

study::UnitSettings take_units(Arguments& arguments) {
  study::UnitSettings units;
  py::object windows = py::none();
  arguments.take("window", units.window);
  arguments.take("windows", windows);
  arguments.take("circle", units.circle);
  arguments.take("edge", units.edge);
  arguments.take("buffer", units.buffer_m);
  arguments.take("per", units.per);
  arguments.take("neighbors", units.neighbors);
  arguments.take("alpha", units.alpha);
  arguments.take("dominance", units.dominance);
  arguments.take("crowding", units.crowding);
  arguments.take("further", units.further);
  arguments.take("competition_radius", units.competition_radius_m);
  arguments.take("open_grown", units.open_grown);
  units.windows = windows_of(windows);
  return units;
}

study::SamplingSettings take_sampling(Arguments& arguments) {
  study::SamplingSettings sampling;
  py::object plots = py::none();
  arguments.take("plots", plots);
  if (!plots.is_none()) sampling.plots = source_of(plots);
  std::map<std::string, std::string> columns;
  arguments.take("plots_columns", columns);
  for (const auto& [name, source] : columns) sampling.plots_columns.push_back(name + "=" + source);
  arguments.take("circles", sampling.circles);
  arguments.take("angle_count", sampling.angle_count);
  arguments.take("smallest_dbh", sampling.smallest_dbh_cm);
  arguments.take("expansion", sampling.expansion);
  arguments.take("expansion_area", sampling.expansion_area);
  arguments.take("subplots", sampling.subplots);
  arguments.take("subplot", sampling.subplot);
  arguments.take("slope_correction", sampling.slope_correction);
  return sampling;
}

study::EquationSettings take_equations(Arguments& arguments) {
  study::EquationSettings settings;
  std::string models;
  arguments.take("equations", settings.equations);
  arguments.take("equation_files", settings.files);
  arguments.take("models", models);
  settings.models = models;
  return settings;
}

std::vector<stand::NamedWindow> windows_of(const py::object& windows) {
  std::vector<stand::NamedWindow> result;
  if (windows.is_none()) return result;
  using Entry = std::pair<std::optional<std::string>, std::vector<std::vector<Ring>>>;
  for (const Entry& entry : windows.cast<std::vector<Entry>>()) {
    std::vector<stand::Polygon> polygons;
    for (const std::vector<Ring>& rings : entry.second) polygons.push_back(polygon_of(rings));
    result.push_back({.plot = entry.first, .window = stand::Window(polygons)});
  }
  return result;
}

std::vector<std::size_t> rows_of(const data::Table& table) {
  std::vector<std::size_t> rows;
  rows.reserve(table.rows());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    rows.push_back(table.line(row) > 0 ? table.line(row) - 1 : row);
  }
  return rows;
}

}  // namespace silvafit::python
