// SPDX-License-Identifier: MIT
#include "silvafit/stand/odd_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/stand/tree_columns.hpp"
#include "trees/inventory_checks.hpp"

namespace silvafit::stand {

void OddValues::add(std::string_view name,
                    std::span<const double> values,
                    const PlaceOfRow& place_of) {
  const auto& columns = tree_columns();
  const auto column = std::ranges::find(columns, name, &TreeColumn::name);
  if (column == columns.end() || column->range.largest == 0.0) return;
  Beyond& beyond = beyond_[static_cast<std::size_t>(column - columns.begin())];
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (!std::isnan(values[row])) ++beyond.values;
    if (values[row] > beyond.largest) {
      beyond.next = std::exchange(beyond.largest, values[row]);
      beyond.place = place_of(row);
    } else if (values[row] > beyond.next) {
      beyond.next = values[row];
    }
    if (!(values[row] > column->range.largest) || beyond.count++ > 0) continue;
    Place place = place_of(row);
    place.column = column->name;
    beyond.first = describe(place, fmt::format("{} {} is odd", values[row], column->unit));
  }
}

std::vector<std::string> OddValues::notes() const {
  // A slip of the decimal point is a factor of 10; nearer to it than to 1 is more than its root.
  constexpr double kSlip = 3.1623;
  std::vector<std::string> notes;
  for (const auto& [at, beyond] : beyond_) {
    const TreeColumn& column = tree_columns()[at];
    const auto& [first, count, values, largest, next, place_of_largest] = beyond;
    if (count == 0 && values >= kEnoughTrees && next > 0.0 && largest > kSlip * next) {
      Place place = place_of_largest;
      place.column = column.name;
      notes.push_back(describe(
          place,
          fmt::format(
              "{} {} is {:.1f} times the next largest value, {}; is a decimal point missing?",
              largest,
              column.unit,
              largest / next,
              next)));
    }
    if (count == 0) continue;
    std::string note = first;
    if (count > 1) {
      note += fmt::format(
          ", and {} more values above {} {}", count - 1, column.range.largest, column.unit);
    }
    notes.push_back(std::move(note));
  }
  return notes;
}

}  // namespace silvafit::stand
