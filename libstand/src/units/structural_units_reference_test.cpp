// SPDX-License-Identifier: MIT
// Structural units against those of an independent implementation in R, itself checked with the
// package forestSAS 2.0.4: ten simulated plots, 4895 trees.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/stand/structural_units.hpp"

using namespace silvafit::stand;
using silvafit::data::Table;
using silvafit::test::reference_data;

namespace {

/// The ten plots of 100 x 50 m, as fir_mixed_truth.json has them.
std::vector<NamedWindow> plot_windows() {
  std::vector<NamedWindow> windows{
      {.plot = "1", .window = Window::rectangle({100.0, 0.0}, {200.0, 50.0})}};
  for (int plot = 2; plot <= 10; ++plot) {
    const int row = (plot - 2) / 3;
    const Point low{100.0 * ((plot - 2) % 3), 50.0 + 50.0 * row};
    windows.push_back({.plot = std::to_string(plot),
                       .window = Window::rectangle(low, {low.x + 100.0, low.y + 50.0})});
  }
  return windows;
}

std::size_t differences(std::span<const double> expected, const std::vector<double>& found) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (expected[i] != found[i]) ++count;
  }
  return count;
}

}  // namespace

TEST_CASE("4895 trees have the structural units of the reference", "[reference]") {
  const Table expected = silvafit::data::read_csv_table(reference_data("fir_mixed/indices.csv"));
  const CheckedInventory checked = read_inventory(reference_data("fir_mixed/inventory.csv"));
  const Inventory& inventory = checked.inventory;
  REQUIRE(checked.excluded.empty());
  REQUIRE(inventory.size() == 4895);
  REQUIRE(expected.rows() == 4895);

  StructuralUnitOptions options{
      .scope = SearchScope::kStand,
      .windows = read_windows(reference_data("fir_mixed/window.geojson"))};
  const StructuralUnits units = structural_units(inventory, options);
  CHECK(units.alpha0_deg == 72.0);
  CHECK(units.notes.empty());
  CHECK(differences(expected.numbers("W"), units.W) == 0);
  CHECK(differences(expected.numbers("M"), units.M) == 0);
  CHECK(differences(expected.numbers("U"), units.U) == 0);
  CHECK(differences(expected.numbers("C"), units.C) == 0);

  std::size_t wrong_core = 0;
  std::size_t wrong_neighbors = 0;
  double largest_error = 0.0;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if ((expected.numbers("in_core")[i] == 1.0) != (units.core[i] != 0)) ++wrong_core;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::string number = std::to_string(k + 1);
      const std::uint32_t neighbor = units.nearest[4 * i + k];
      const std::string id = silvafit::data::shortest(expected.numbers("nn" + number)[i]);
      if (inventory.tree[neighbor] != id) ++wrong_neighbors;
      const double distance = expected.numbers("d" + number)[i];
      largest_error =
          std::max(largest_error, std::abs(units.distance_m[4 * i + k] - distance) / distance);
    }
  }
  CHECK(wrong_core == 0);
  CHECK(wrong_neighbors == 0);
  // The reference is written with 15 digits.
  CHECK(largest_error < 1e-14);

  options.windows = plot_windows();
  const StructuralUnits by_plot_window = structural_units(inventory, options);
  std::size_t wrong_plot_core = 0;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if ((expected.numbers("in_core_plot")[i] == 1.0) != (by_plot_window.core[i] != 0)) {
      ++wrong_plot_core;
    }
  }
  CHECK(wrong_plot_core == 0);
  CHECK(by_plot_window.nearest == units.nearest);
}

TEST_CASE("the number of threads changes nothing", "[reference]") {
  const Inventory inventory = read_inventory(reference_data("fir_mixed/inventory.csv")).inventory;
  const auto csv_with = [&inventory](unsigned threads) {
    const StructuralUnits units = structural_units(inventory, {.threads = threads});
    std::ostringstream stream;
    write_structural_units(inventory, units, stream);
    return stream.str();
  };
  CHECK(csv_with(1) == csv_with(3));
}
