// SPDX-License-Identifier: MIT
// Windows from CSV: well-known text by plot, as geographic information systems export it, circular
// plots, or the corners of plots.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"
#include "trees/column_sources.hpp"
#include "windows/window_files.hpp"

namespace silvafit::stand {
namespace {

class CsvWindowReader {
 public:
  explicit CsvWindowReader(const data::TableSource& table)
      : file_(data::file_of(table)), csv_(table), header_(csv_.header()) {
    plot_ = plot_field();
    wkt_ = field_in_any_case("wkt", header_);
    x_ = field_in_any_case("x", header_);
    y_ = field_in_any_case("y", header_);
    radius_ = field_in_any_case("radius", header_);
    if (wkt_ || (x_ && y_)) return;
    throw InputError(fmt::format("windows need the column wkt, or x, y and radius, or x and y of "
                                 "the corners in order, and plot if there are several plots; "
                                 "available: {}",
                                 data::list_of(header_)),
                     {.file = file_});
  }

  std::vector<NamedWindow> read();

 private:
  std::optional<std::size_t> plot_field() const;
  void add_row(const std::vector<std::string_view>& fields);
  void add_polygons_of_corners();
  double number(const std::vector<std::string_view>& fields, std::size_t field);

  std::string file_;
  data::CsvReader csv_;
  std::vector<std::string> header_;
  std::optional<std::size_t> plot_{};
  std::optional<std::size_t> wkt_{};
  std::optional<std::size_t> x_{};
  std::optional<std::size_t> y_{};
  std::optional<std::size_t> radius_{};
  /// The corners of a plot in the order of their rows.
  struct Ring {
    std::optional<std::string> plot{};
    std::size_t line = 0;  ///< of the first corner
    std::vector<Point> corners{};
  };
  std::vector<Ring> rings_{};
  std::map<std::optional<std::string>, std::size_t> ring_of_{};
  WindowCollector collector_{};
};

/// The column of plots, under its standard name or a usual one.
std::optional<std::size_t> CsvWindowReader::plot_field() const {
  if (const auto own = field_in_any_case("plot", header_)) return own;
  const auto is_plot = [](const std::string& name) { return name == "plot"; };
  const std::vector<ColumnMapping> usual = usual_columns(header_, is_plot, file_);
  return usual.empty() ? std::nullopt : field_in_any_case(usual.front().source, header_);
}

double CsvWindowReader::number(const std::vector<std::string_view>& fields, std::size_t field) {
  double value = 0.0;
  if (csv_.read_number(field, fields[field], value)) return value;
  throw InputError(fmt::format("'{}' is not a number", fields[field]),
                   {.file = file_, .line = csv_.line(), .column = header_[field]});
}

void CsvWindowReader::add_row(const std::vector<std::string_view>& fields) {
  std::optional<std::string> plot;
  if (plot_ && !data::is_missing_field(fields[*plot_])) {
    plot = std::string(data::trimmed(fields[*plot_]));
  }
  if (wkt_) return collector_.add(plot, polygons_of_wkt(fields[*wkt_]));
  const Point point{number(fields, *x_), number(fields, *y_)};
  if (radius_) return collector_.add_circle(plot, point, number(fields, *radius_));
  const auto [ring, is_new] = ring_of_.try_emplace(plot, rings_.size());
  if (is_new) rings_.push_back({.plot = plot, .line = csv_.line()});
  rings_[ring->second].corners.push_back(point);
}

void CsvWindowReader::add_polygons_of_corners() {
  for (const Ring& ring : rings_) {
    try {
      collector_.add(ring.plot, {Polygon{.outer = ring.corners}});
    } catch (const GeometryError& error) {
      throw InputError(
          fmt::format("{}; the rows of a plot must be its corners, three or more, in the order in "
                      "which they follow each other around it",
                      error.message()),
          {.file = file_, .line = ring.line, .plot = ring.plot.value_or("")});
    }
  }
}

std::vector<NamedWindow> CsvWindowReader::read() {
  std::vector<std::string_view> fields;
  while (csv_.next(fields)) {
    try {
      add_row(fields);
    } catch (const GeometryError& error) {
      throw InputError(error.message(), {.file = file_, .line = csv_.line()});
    }
  }
  add_polygons_of_corners();
  std::vector<std::size_t> numbers;
  for (const auto& field : {x_, y_, radius_}) {
    if (field) numbers.push_back(*field);
  }
  csv_.require_clear_marks(numbers);
  return collector_.windows(file_);
}

}  // namespace

std::vector<NamedWindow> read_csv_windows(const std::filesystem::path& path) {
  return CsvWindowReader(path).read();
}

std::vector<NamedWindow> windows_of_table(const data::TableSource& table) {
  return CsvWindowReader(table).read();
}

}  // namespace silvafit::stand
