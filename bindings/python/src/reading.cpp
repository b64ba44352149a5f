// SPDX-License-Identifier: MIT
#include "reading.hpp"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>

#include "setting_keywords.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/setting_list.hpp"
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
  return settings_of<study::ReadingSettings>(arguments);
}

study::UnitSettings take_units(Arguments& arguments) {
  py::object windows = py::none();
  arguments.take("windows", windows);
  auto units = settings_of<study::UnitSettings>(arguments);
  units.windows = windows_of(windows);
  return units;
}

study::SamplingSettings take_sampling(Arguments& arguments) {
  study::SamplingSettings sampling;
  py::object plots = py::none();
  arguments.take("plots", plots);
  if (!plots.is_none()) sampling.plots = source_of(plots);
  return settings_of(arguments, std::move(sampling));
}

study::EquationSettings take_equations(Arguments& arguments) {
  auto settings = settings_of<study::EquationSettings>(arguments);
  std::string models;
  arguments.take("models_folder", models);
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
