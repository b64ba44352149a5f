// SPDX-License-Identifier: MIT
#include "trees/polar_positions.hpp"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/expression.hpp"
#include "trees/column_sources.hpp"
#include "trees/usual_names.hpp"

namespace silvafit::stand {

PolarColumn polar_column(const std::string& column,
                         const std::string& position,
                         const std::vector<std::string>& header,
                         const std::vector<std::string>& units,
                         const std::vector<ColumnMapping>& mapped) {
  const auto is_read_as = [&](std::string_view name) {
    const ColumnMapping* const mapping = mapping_to(name, mapped);
    const auto meant = meant_name(column);
    return mapping != nullptr ? mapping->source == column : meant && meant->name == name;
  };
  if (is_read_as("distance")) return {.is_distance = true};
  if (!is_read_as("azimuth")) return {};
  if (position.find("/200)") != std::string::npos) return {.full_circle = 400.0};
  const auto field = field_named(column, header);
  return {.full_circle = 360.0 / degrees_of_field(*field, header, units).value_or(1.0)};
}

void require_polar(double value, const PolarColumn& column, const Place& place) {
  if (column.is_distance && value < 0.0) {
    throw InputError(
        fmt::format("the distance {} is negative; leave unknown distances empty, or name their "
                    "code with `missing`",
                    value),
        place);
  }
  if (column.full_circle == 0.0 || std::isnan(value)) return;
  if (value >= 0.0 && value <= column.full_circle) return;
  const std::string name = data::Expression::variable(place.column).text();
  const std::string unit =
      value < 0.0 ? fmt::format(
                        "if the column goes from -180 to 180, use "
                        "`columns=azimuth=ifelse({0} < 0, {0} + 360, {0})`",
                        name)
      : value <= 400.0 ? fmt::format(
                             "if it is in gon, use `columns=azimuth={0}*0.9`; if it is in "
                             "degrees with a declination, use `columns=azimuth={0}*1`",
                             name)
                       : fmt::format("if it is in mils, use `columns=azimuth={}*360/6400`", name);
  throw InputError(fmt::format("the azimuth {} is not from 0 to {}; {}; leave unknown directions "
                               "empty, or name their code with `missing`",
                               value,
                               column.full_circle,
                               unit),
                   place);
}

void check_polar_positions(const data::Table& table,
                           const std::string& position,
                           const std::vector<std::string>& header,
                           const std::vector<std::string>& units,
                           const std::vector<ColumnMapping>& mapped) {
  for (const std::string& name : data::Expression::parse(position).variables()) {
    if (!table.has(name) || !table.is_numeric(name)) continue;
    const PolarColumn column = polar_column(name, position, header, units, mapped);
    if (column.full_circle == 0.0 && !column.is_distance) continue;
    const std::span<const double> values = table.numbers(name);
    for (std::size_t row = 0; row < values.size(); ++row) {
      require_polar(values[row], column, data::place_of(table, row, name));
    }
  }
}

}  // namespace silvafit::stand
