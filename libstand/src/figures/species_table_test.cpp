// SPDX-License-Identifier: MIT
// Importance values, quadrats and layers.
#include "silvafit/stand/species_table.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "test_support/stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;

TEST_CASE("importance values need no areas, values per hectare do") {
  const Inventory stand = stand_of({{.dbh_cm = 20.0, .h_m = 15.0}, {.dbh_cm = 30.0, .h_m = 18.0}});
  const std::vector<SpeciesRow> known = species_table(stand, sampled_areas(stand, 500.0));
  const std::vector<SpeciesRow> rows = species_table(stand, plots_of_unknown_area(stand));
  REQUIRE(rows.size() == known.size());
  CHECK(rows[0].all.value == known[0].all.value);
  CHECK(rows[0].figures.mean_height_m == known[0].figures.mean_height_m);
  CHECK(std::isnan(rows[0].figures.stems_per_ha));
  CHECK(std::isnan(rows[0].figures.basal_area_m2_per_ha));
  CHECK(std::isnan(rows[0].figures.dominant_height_m));
}

TEST_CASE("importance values are the mean of three shares, in all and by layer") {
  // Two plots. A: three trees of 20 cm in both; B: one of 40 cm in the first.
  const Inventory stand = stand_of({{.dbh_cm = 20, .species = "A", .plot = "1", .h_m = 9},
                                    {.dbh_cm = 20, .species = "A", .plot = "1", .h_m = 10},
                                    {.dbh_cm = 40, .species = "B", .plot = "1", .h_m = 20},
                                    {.dbh_cm = 20, .species = "A", .plot = "2", .h_m = 19}});
  const std::vector<SpeciesRow> rows = species_table(stand, sampled_areas(stand, 5000.0));
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].species == "A");
  const Importance& a = rows[0].all;
  CHECK(a.relative_density == Approx(75.0).epsilon(1e-14));
  CHECK(a.relative_frequency == Approx(200.0 / 3.0).epsilon(1e-14));
  // 3 * 400 of 3 * 400 + 1600
  CHECK(a.relative_dominance == Approx(100.0 * 1200.0 / 2800.0).epsilon(1e-13));
  CHECK(a.value == Approx((75.0 + 200.0 / 3.0 + 300.0 / 7.0) / 3.0).epsilon(1e-13));
  // Plot 1: (2/3 + 1/2 + 1/3) / 3 = 1/2; plot 2: 1.
  CHECK(a.plot_mean == Approx(75.0).epsilon(1e-13));
  CHECK(a.plot_sd == Approx(std::sqrt(1250.0)).epsilon(1e-13));
  CHECK(rows[0].figures.stems_per_ha == Approx(3.0).epsilon(1e-14));
  CHECK(rows[0].basal_area_m2 == Approx(3.0 * basal_area_m2(20)).epsilon(1e-14));
  REQUIRE(rows[0].layers.size() == 3);
  CHECK(rows[0].layers[0].value == Approx(100.0).epsilon(1e-14));
  CHECK(rows[0].layers[1].value == Approx(100.0).epsilon(1e-14));
  CHECK(rows[0].layers[2].value == 0.0);
  CHECK(rows[1].layers[2].value == Approx(100.0).epsilon(1e-14));
}

TEST_CASE("trees on the window's own border are in its last quadrats") {
  // Four quadrats of 10 m: A in the south-west and the south-east one, B in the south-east and the
  // north-east one, both within and on the border of the window.
  struct Case {
    Point corner{};
    double scale = 1.0;
  };
  for (const auto& [corner, scale] : {Case{{0.0, 0.0}, 1.0},
                                      Case{{512345.678, 6123456.789}, 1.0},
                                      Case{{9512345.678, 19123456.789}, 0.03}}) {
    const auto tree = [at = corner, by = scale](double x, double y, const char* species) {
      return Tree{.x = at.x + by * x, .y = at.y + by * y, .species = species};
    };
    const Inventory stand = stand_of({tree(5, 5, "A"),
                                      tree(15, 5, "A"),
                                      tree(19, 5, "B"),
                                      tree(20, 5, "B"),
                                      tree(19, 19, "B"),
                                      tree(20, 19, "B"),
                                      tree(19, 20, "B"),
                                      tree(20, 20, "B")});
    const auto frequency_of = [&, at = corner, by = scale](double quadrat_m, double width_m) {
      const Window window = Window::rectangle(at, {at.x + by * width_m, at.y + by * 20.0});
      const std::vector<SampledArea> areas{
          {.area_m2 = window.area_m2(), .window = window, .trees = all_rows(stand)}};
      const auto rows = species_table(stand, areas, {.quadrat_m = by * quadrat_m});
      return row_of(rows, "A").all.relative_frequency;
    };
    CHECK(frequency_of(10.0, 20.0) == Approx(50.0).epsilon(1e-14));
    // One quadrat, which both are in.
    CHECK(frequency_of(20.0, 20.0) == Approx(50.0).epsilon(1e-14));
    // In a wider window the border at 20 m is an inner one with quadrats beyond: B is in four.
    CHECK(frequency_of(10.0, 25.0) == Approx(100.0 / 3.0).epsilon(1e-14));
    // Quadrats of 15 m: the tree of A at 15 m is in the narrow one, as B is.
    CHECK(frequency_of(15.0, 20.0) == Approx(50.0).epsilon(1e-14));
  }
}

TEST_CASE("layers are half-open, and trees without height are in none") {
  const Layers layers;
  CHECK(layers.layer_of(9.99) == 0);
  CHECK(layers.layer_of(10.0) == 1);
  CHECK(layers.layer_of(20.0) == 2);
  CHECK(layers.layer_of(NAN) == 3);
  CHECK(layers.name_of(2) == "upper");
  const Layers four{.bounds_m = {5, 12, 20}};
  CHECK(four.name_of(0) == "below 5 m");
  CHECK(four.name_of(1) == "5-12 m");
  CHECK(four.name_of(3) == "20 m and more");
  const Inventory stand = stand_of({{}, {.x = 1}});
  CHECK_THROWS_WITH(species_table(stand, sampled_areas(stand, 100.0), {.layers = {{10, 10}}}),
                    Contains("`layers`"));
  CHECK_THROWS_WITH(species_table(stand, sampled_areas(stand, 100.0), {.quadrat_m = 5.0}),
                    Contains("`quadrat`"));
}
