// SPDX-License-Identifier: MIT
#include "workflow/terrain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "workflow/mapped_numbers.hpp"

namespace silvafit::study {
namespace {

/// "412.5 to 430.1"; empty without a known value.
std::string range_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return "unknown";
  const auto [low, high] = std::ranges::minmax(values);
  return fmt::format("{:.1f} to {:.1f}", low, high);
}

[[noreturn]] void refuse_terrain(const data::Raster& terrain,
                                 const data::Table& table,
                                 const std::vector<double>& x,
                                 const std::vector<double>& y) {
  throw InputError(fmt::format("no tree is on the terrain {}, whose x is {:.1f} to {:.1f} and y "
                               "{:.1f} to {:.1f}; x of the trees is {}, y {}",
                               terrain.file,
                               terrain.x_of(0),
                               terrain.x_of(terrain.columns - 1),
                               terrain.y_of(terrain.rows - 1),
                               terrain.y_of(0),
                               range_of(x),
                               range_of(y)),
                   {.file = table.file()});
}

}  // namespace

void set_elevations(const data::Raster& terrain,
                    data::Table& table,
                    std::map<std::string, std::string>& columns,
                    bool is_whole,
                    std::size_t& off_terrain,
                    std::vector<std::string>& notes) {
  // Texts in x or y are reported where positions are read.
  std::vector<data::TextCell> texts;
  const std::vector<double> x = mapped_numbers(table, columns, "x", texts);
  const std::vector<double> y = mapped_numbers(table, columns, "y", texts);
  std::vector<double> z(table.rows());
  for (std::size_t row = 0; row < z.size(); ++row) {
    z[row] = terrain.at(x[row], y[row]);
    if (std::isnan(z[row]) && !std::isnan(x[row]) && !std::isnan(y[row])) ++off_terrain;
  }
  const bool is_off = std::ranges::all_of(z, [](double value) { return std::isnan(value); });
  if (is_whole && is_off) refuse_terrain(terrain, table, x, y);
  const bool has_own = table.has("z") || columns.contains("z");
  notes.push_back(fmt::format("elevations are those of {}{}{}",
                              terrain.file,
                              has_own ? "; z of the trees is not used" : "",
                              off_terrain == 0
                                  ? ""
                                  : fmt::format("; {} outside of it or where it is unknown",
                                                counted(off_terrain, "tree is", "trees are"))));
  columns.erase("z");
  table.set("z", std::move(z));
}

}  // namespace silvafit::study
