// SPDX-License-Identifier: MIT
// Stand figures, strata, importance values and structural classes.
#include "silvafit/stand/stand_report.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "reference.hpp"
#include "scratch_file.hpp"
#include "silvafit/base/error.hpp"
#include "stand_test_support.hpp"

using namespace silvafit::stand;
using namespace silvafit::stand::test;
using Catch::Matchers::Contains;
using silvafit::test::reference_file;

namespace {

std::vector<std::size_t> all_rows(const Inventory& inventory) {
  std::vector<std::size_t> rows(inventory.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  return rows;
}

double basal_m2(double dbh_cm) { return M_PI * dbh_cm * dbh_cm / 4e4; }

const SpeciesRow& row_of(const std::vector<SpeciesRow>& rows, const std::string& species) {
  for (const SpeciesRow& row : rows) {
    if (row.species == species) return row;
  }
  throw std::runtime_error("no species " + species);
}

}  // namespace

TEST_CASE("stand figures are those computed by hand") {
  Inventory stand = stand_of({{.dbh_cm = 10, .cw_m = 2, .h_m = 8},
                              {.dbh_cm = 20, .cw_m = 4, .h_m = 16},
                              {.dbh_cm = 30, .cw_m = 6, .h_m = 21},
                              {.dbh_cm = 30, .cw_m = 5, .h_m = 24}});
  // 200 m2, so that 100 trees a hectare are 2.
  const StandFigures figures = stand_figures(stand, all_rows(stand), 200.0);
  CHECK(figures.trees == 4);
  CHECK(figures.area_ha == 0.02);
  CHECK(figures.stems_per_ha == Approx(200.0).epsilon(1e-14));
  const double basal = basal_m2(10) + basal_m2(20) + 2 * basal_m2(30);
  CHECK(figures.basal_area_m2_per_ha == Approx(basal / 0.02).epsilon(1e-14));
  CHECK(figures.mean_dbh_cm == 22.5);
  CHECK(figures.sd_dbh_cm == Approx(std::sqrt(275.0 / 3.0)).epsilon(1e-14));
  CHECK(figures.quadratic_mean_dbh_cm == Approx(std::sqrt(2300.0 / 4.0)).epsilon(1e-14));
  CHECK(figures.mean_height_m == 17.25);
  CHECK(figures.lorey_height_m ==
        Approx((100 * 8 + 400 * 16 + 900 * 21 + 900 * 24) / 2300.0).epsilon(1e-14));
  CHECK(figures.dominant_height_m == 22.5);
  CHECK(stand_figures(stand, all_rows(stand), 100.0).dominant_height_m == 24.0);
  CHECK(figures.crown_cover_percent ==
        Approx(100.0 * M_PI / 4.0 * (4 + 16 + 36 + 25) / 200.0).epsilon(1e-14));
  // A thick tree without height takes its place among the thickest, but has none in the mean.
  stand.h_m[3] = NAN;
  CHECK(stand_figures(stand, all_rows(stand), 200.0).dominant_height_m == 21.0);
  const StandFigures nothing = stand_figures(stand, {}, 200.0);
  CHECK(nothing.stems_per_ha == 0.0);
  CHECK(std::isnan(nothing.quadratic_mean_dbh_cm));
  CHECK(std::isnan(nothing.dominant_height_m));
}

TEST_CASE("crown cover is that of the trees with a crown width, and others are counted") {
  Inventory stand = stand_of({{.x = 0, .y = 0, .cw_m = 2},
                              {.x = 9, .y = 0, .cw_m = NAN},
                              {.x = 9, .y = 9, .cw_m = 4},
                              {.x = 0, .y = 9, .cw_m = NAN}});
  const StandFigures figures = stand_figures(stand, all_rows(stand), 100.0);
  // pi / 4 (4 + 16) m2 of 100 m2
  CHECK(figures.crown_cover_percent == Approx(5.0 * M_PI).epsilon(1e-14));
  CHECK(figures.trees_without_crown_width == 2);
  const auto notes_of = [&stand] {
    std::string all;
    StandReportOptions options{.units = {.neighbors = 1}};
    options.plot_area_m2 = 100.0;
    for (const std::string& note : stand_report(stand, options).notes) all += note + "\n";
    return all;
  };
  CHECK_THAT(notes_of(),
             Contains("2 of 4 trees have no crown width and are not in the crown "
                      "cover, which is too small by their crowns"));
  stand.cw_m[1] = 3;
  CHECK_THAT(notes_of(), Contains("1 of 4 trees has no crown width and is not in the crown cover"));
  stand.cw_m[3] = 3;
  CHECK_THAT(notes_of(), !Contains("crown cover"));
  // Where none is known, neither is the cover.
  stand.cw_m.assign(4, NAN);
  CHECK(std::isnan(stand_figures(stand, all_rows(stand), 100.0).crown_cover_percent));
  CHECK_THAT(notes_of(), !Contains("crown cover"));
  stand.cw_m.clear();
  CHECK(std::isnan(stand_figures(stand, {}, 100.0).crown_cover_percent));
}

TEST_CASE("diameter classes begin at their lower limit") {
  const Inventory stand =
      stand_of({{.dbh_cm = 7.9}, {.dbh_cm = 8.0}, {.dbh_cm = 11.9}, {.dbh_cm = 16.3}});
  const auto classes = diameter_distribution(stand, all_rows(stand), 1e4, 4.0);
  REQUIRE(classes.size() == 4);
  CHECK(classes[0].low_cm == 4.0);
  CHECK(classes[0].trees == 1);
  CHECK(classes[1].trees == 2);
  CHECK(classes[2].trees == 0);
  CHECK(classes[3].trees == 1);
  CHECK(classes[3].high_cm == 20.0);
  CHECK(classes[1].basal_area_m2_per_ha == Approx(basal_m2(8) + basal_m2(11.9)).epsilon(1e-14));
  // 0.3 is just below three tenths in binary numbers.
  const Inventory small = stand_of({{.dbh_cm = 0.3}});
  CHECK(diameter_distribution(small, all_rows(small), 1e4, 0.1)[0].low_cm ==
        Approx(0.3).epsilon(1e-14));
  CHECK_THROWS_WITH(diameter_distribution(stand, all_rows(stand), 1e4, 0.0),
                    Contains("--class-width"));
  CHECK_THROWS_WITH(diameter_distribution(stand, all_rows(stand), 1e4, 1e-6),
                    Contains("too narrow"));
}

TEST_CASE("strata are estimated as Cochran's ratio, and summed by their areas") {
  // Three plots in A with 4, 6 and 8 trees on 0.1 ha each, and B with 2 trees on 0.1, 9 on 0.3 ha.
  std::vector<Tree> trees;
  const auto add = [&trees](const char* plot, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) trees.push_back({.dbh_cm = 20, .plot = plot});
  };
  add("1", 4);
  add("2", 6);
  add("3", 8);
  add("4", 2);
  add("5", 9);
  const Inventory stand = stand_of(trees);
  std::vector<SampledArea> areas = sampled_areas(stand, 1000.0);
  REQUIRE(areas.size() == 5);
  areas[4].area_m2 = 3000.0;
  const auto result =
      stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"A", 30.0}, {"B", 10.0}});
  REQUIRE(result.size() == 3);
  const StratumFigures& first = result[0];
  CHECK(first.name == "A");
  CHECK(first.plots == 3);
  CHECK(first.stems.per_ha == Approx(60.0).epsilon(1e-14));
  // Equal plots: the standard error of a mean of 40, 60 and 80 is 20 / sqrt(3).
  CHECK(first.stems.standard_error == Approx(20.0 / std::sqrt(3.0)).epsilon(1e-14));
  CHECK(first.stems.total == Approx(1800.0).epsilon(1e-14));
  CHECK(first.basal_area_m2.per_ha == Approx(60.0 * basal_m2(20)).epsilon(1e-14));
  // B: ratio 11 / 0.4; deviations 2 - 2.75 and 9 - 8.25.
  const StratumFigures& second = result[1];
  CHECK(second.stems.per_ha == Approx(27.5).epsilon(1e-14));
  const double error = std::sqrt(2.0 * 0.75 * 0.75 / 2.0) / 0.2;
  CHECK(second.stems.standard_error == Approx(error).epsilon(1e-13));
  const StratumFigures& all = result[2];
  CHECK(all.name.empty());
  CHECK(all.area_ha == 40.0);
  CHECK(all.stems.total == Approx(2075.0).epsilon(1e-14));
  CHECK(all.stems.total_standard_error ==
        Approx(std::hypot(30.0 * 20.0 / std::sqrt(3.0), 10.0 * error)).epsilon(1e-13));

  CHECK(stratum_figures(stand, areas, {}, {}).size() == 1);
  CHECK(stratum_figures(stand, areas, {}, {})[0].stems.per_ha == Approx(29.0 / 0.7).epsilon(1e-14));
  CHECK_THROWS_WITH(stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"A", 30.0}}),
                    Contains("area of stratum 'B' is not given"));
  CHECK_THROWS_WITH(stratum_figures(stand, areas, {"A", "A", "A", "B", "B"}, {{"C", 30.0}}),
                    Contains("no stratum 'C'"));
  CHECK(std::isnan(stratum_figures(stand, {areas[0]}, {}, {})[0].stems.standard_error));
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
  CHECK(rows[0].basal_area_m2 == Approx(3.0 * basal_m2(20)).epsilon(1e-14));
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
                    Contains("--layers"));
  CHECK_THROWS_WITH(species_table(stand, sampled_areas(stand, 100.0), {.quadrat_m = 5.0}),
                    Contains("--quadrat"));
}

TEST_CASE("joint distributions count core trees by both classes") {
  StructuralUnits units{.neighbors = 2,
                        .core = {1, 1, 1, 0, 1},
                        .W = {0.0, 0.5, 0.5, 1.0, NAN},
                        .M = {1.0, 0.0, 0.0, 1.0, 1.0}};
  const JointDistribution joint = joint_distribution(units, "W", "M");
  CHECK(joint.trees == 3);
  CHECK(joint.at(0, 2) == Approx(1.0 / 3.0).epsilon(1e-15));
  CHECK(joint.at(1, 0) == Approx(2.0 / 3.0).epsilon(1e-15));
  CHECK(std::accumulate(joint.share.begin(), joint.share.end(), 0.0) == Approx(1.0).epsilon(1e-15));
  units.weight = {2, 1, 1, 9, 1};
  CHECK(joint_distribution(units, "W", "M").at(0, 2) == 0.5);
  CHECK(std::isnan(joint_distribution(units, "C", "M").at(0, 0)));
  CHECK_THROWS_AS(joint_distribution(units, "T", "M"), silvafit::UsageError);
}

TEST_CASE("Clark and Evans's index tells lattices from clusters") {
  std::vector<Point> lattice;
  std::vector<Point> pairs;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      lattice.push_back({5.0 * i + 2.5, 5.0 * j + 2.5});
      pairs.push_back({10.0 * (i / 2) + 0.01 * (i % 2) + 5.0, 5.0 * j + 2.5});
    }
  }
  const Window window = Window::rectangle({0, 0}, {100, 100});
  // A square lattice has R = 2; on the triangular one it is 2.149.
  CHECK(clark_evans(lattice, window).R == Approx(2.0).epsilon(1e-12));
  CHECK(clark_evans(lattice, window).p < 1e-10);
  CHECK(clark_evans(pairs, window).R < 0.01);
  CHECK(std::isnan(clark_evans(std::vector<Point>{{1, 1}}, window).R));
  // Stems at one place are at distance 0.
  CHECK(clark_evans(std::vector<Point>{{1, 1}, {1, 1}, {5, 5}}, window).mean_distance_m ==
        Approx(std::sqrt(32.0) / 3.0).epsilon(1e-14));
}

TEST_CASE("Donnelly's correction takes the boundary's part from random stands") {
  double plain = 0.0;
  double corrected = 0.0;
  constexpr int kRounds = 200;
  for (int round = 0; round < kRounds; ++round) {
    silvafit::Random random(static_cast<std::uint64_t>(round));
    std::vector<Point> points;
    for (int i = 0; i < 60; ++i) points.push_back({random.uniform(0, 60), random.uniform(0, 40)});
    const ClarkEvans index = clark_evans(points, Window::rectangle({0, 0}, {60, 40}));
    plain += index.R / kRounds;
    corrected += index.R_donnelly / kRounds;
  }
  // Standard error of one index 0.52 / sqrt(60) = 0.067, of the mean 0.005.
  CHECK(corrected == Approx(1.0).margin(0.015));
  CHECK(plain > 1.03);
}

TEST_CASE("a report counts plots without trees, and says what it leaves out") {
  Inventory stand = stand_of({{.x = 1, .plot = "1"},
                              {.x = 3, .plot = "1"},
                              {.x = 99, .plot = "1"},
                              {.x = 21, .plot = "2"}});
  StandReportOptions options{.units = {.neighbors = 1,
                                       .windows = {{"1", Window::rectangle({0, -10}, {20, 10})},
                                                   {"2", Window::rectangle({20, -10}, {40, 10})},
                                                   {"3", Window::rectangle({40, -10}, {60, 10})}}}};
  const StandReport report = stand_report(stand, options);
  REQUIRE(report.areas.size() == 3);
  CHECK(report.areas[2].area.name == "3");
  CHECK(report.areas[2].figures.stems_per_ha == 0.0);
  CHECK(report.all.stems_per_ha == Approx(3.0 / 0.12).epsilon(1e-14));
  CHECK(report.strata.back().stems.per_ha == Approx(25.0).epsilon(1e-14));
  const std::string notes = std::accumulate(
      report.notes.begin(), report.notes.end(), std::string(), [](auto all, const auto& note) {
        return all + note + "\n";
      });
  CHECK_THAT(notes,
             Contains("1 tree outside the windows is not counted, but is a neighbor of those "
                      "inside\n"));
  CHECK_THAT(notes, !Contains("stands outside the window"));
  CHECK_THAT(notes, Contains("1 plot has a window and no tree"));

  CHECK_THROWS_WITH(
      stand_report(stand_of({{.x = 1}, {.x = 2}}), {}),
      Contains("no plot has an area") && Contains("--window") && Contains("--plot-area"));

  stand.x.clear();
  stand.y.clear();
  CHECK_THROWS_WITH(stand_report(stand, {}), Contains("--plot-area"));
  const StandReport by_area = stand_report(stand, {.plot_area_m2 = 500.0});
  CHECK_FALSE(by_area.units);
  CHECK(by_area.all.stems_per_ha == Approx(40.0).epsilon(1e-14));
}

TEST_CASE("the simulated inventory has the densities of the paper's Table 1", "[reference]") {
  SILVAFIT_NEEDS_REFERENCE("fir_mixed_inventory.csv");
  const Inventory inventory = read_inventory(reference_file("fir_mixed_inventory.csv")).inventory;
  const StandReport report =
      stand_report(inventory,
                   {.units = {.scope = SearchScope::kStand,
                              .windows = read_windows(reference_file("window.geojson"))}});
  REQUIRE(report.areas.size() == 1);
  CHECK(report.areas[0].figures.area_ha == 5.0);
  // Table 1 of the paper, trees per hectare with one digit.
  const std::vector<std::pair<std::string, double>> densities{{"SM", 273.0},
                                                              {"BHN", 252.6},
                                                              {"MH", 259.0},
                                                              {"OF", 62.0},
                                                              {"MF", 48.0},
                                                              {"VF", 35.6},
                                                              {"LF", 27.0},
                                                              {"SD", 21.8}};
  double sum = 0.0;
  for (const auto& [species, density] : densities) {
    const SpeciesRow& row = row_of(report.species, species);
    CHECK(row.figures.stems_per_ha == Approx(density).epsilon(1e-12));
    sum += row.all.value;
  }
  CHECK(sum == Approx(100.0).epsilon(1e-12));
  // The ranks of the three dominant species, with a clear gap to the others, as in the paper.
  CHECK(report.species[0].species == "SM");
  CHECK(report.species[2].all.value > 2.0 * report.species[3].all.value);
  // in_core of fir_mixed_indices.csv
  CHECK(report.unit_means->core_trees == 4445);
}

TEST_CASE("a stratum of one plot has no standard error, and a note says why") {
  Inventory stand = stand_of({{.dbh_cm = 10}, {.dbh_cm = 20}, {.dbh_cm = 30}});
  stand.plot = {};
  silvafit::data::TextColumn strata;
  for (const char* plot : {"1", "2", "3"}) stand.plot.append(plot);
  for (const char* stratum : {"A", "A", "B"}) strata.append(stratum);
  stand.other = silvafit::data::Table(3);
  stand.other.set("zone", strata);
  StandReportOptions options{.plot_area_m2 = 100.0, .stratum = "zone"};
  const auto notes_on_plots = [&] {
    std::string found;
    for (const std::string& note : stand_report(stand, options).notes) {
      if (note.find("one plot") != std::string::npos) found += note;
    }
    return found;
  };
  // Without the strata's areas all plots are one sample, which has a variance.
  CHECK(notes_on_plots() ==
        "the stratum B has one plot, and a variance needs two: it has no standard error");
  options.stratum_areas_ha = {{"A", 3.0}, {"B", 2.0}};
  CHECK_THAT(notes_on_plots(), Catch::Matchers::EndsWith(", and neither have all strata together"));
  options.stratum_areas_ha.clear();
  options.stratum = "plot";
  CHECK_THAT(notes_on_plots(),
             Catch::Matchers::StartsWith("the strata 1, 2, 3 have each one plot"));
  options.stratum.clear();
  CHECK(notes_on_plots().empty());
}

namespace {

std::string notes_in(const StandReport& report) {
  std::string all;
  for (const std::string& note : report.notes) all += note + "\n";
  return all;
}

}  // namespace

TEST_CASE("plots without a stratum are a row of their own, and are said") {
  Inventory stand = stand_of({{.plot = "1"}, {.plot = "2"}, {.plot = "2"}, {.plot = "3"}});
  silvafit::data::TextColumn strata;
  for (const char* stratum : {"all", "B", "B"}) strata.append(stratum);
  strata.append_missing();
  stand.other = silvafit::data::Table(4);
  stand.other.set("zone", strata);
  StandReportOptions options{.plot_area_m2 = 100.0, .stratum = "zone"};
  using Kind = StratumFigures::Kind;
  const StandReport report = stand_report(stand, options);
  REQUIRE(report.strata.size() == 4);
  CHECK(report.strata[1].name == "all");
  CHECK(report.strata[1].kind == Kind::kStratum);
  CHECK(report.strata[2].kind == Kind::kWithout);
  CHECK(report.strata[2].trees == 1);
  CHECK(report.strata[3].kind == Kind::kAll);
  // Four trees on three ares.
  CHECK(report.strata[3].stems.per_ha == Approx(4.0 / 0.03).epsilon(1e-14));
  CHECK_THAT(notes_in(report), Contains("plot 3 has no stratum in the column zone"));
  CHECK_THAT(notes_in(report), Contains("the strata B, all, (none) have each one plot"));

  // Weighted by areas: 200 stems per ha on 4 ha, 100 on 1 ha; plot 3 stands for no area.
  options.stratum_areas_ha = {{"B", 4.0}, {"all", 1.0}};
  const StandReport weighted = stand_report(stand, options);
  CHECK(weighted.strata[3].plots == 2);
  CHECK(weighted.strata[3].stems.total == Approx(900.0).epsilon(1e-14));
  CHECK(std::isnan(weighted.strata[2].stems.total));
  CHECK_THAT(notes_in(weighted), Contains("and not in those of all together"));
}

TEST_CASE("plots whose trees make no hull are named, and their trees are not outside") {
  const Inventory stand = stand_of({{},
                                    {.x = 10},
                                    {.y = 10},
                                    {.plot = "pair"},
                                    {.x = 1, .plot = "pair"},
                                    {.plot = "line"},
                                    {.x = 1, .plot = "line"},
                                    {.x = 2, .plot = "line"}});
  const StandReport report = stand_report(stand, {.units = {.neighbors = 1}});
  CHECK(report.areas.size() == 1);
  CHECK(report.all.trees == 3);
  CHECK_THAT(notes_in(report), Contains("2 plots are not counted, with 5 trees: plot pair, line"));
  CHECK_THAT(notes_in(report), !Contains("outside"));
}

TEST_CASE("a plot whose rows were all left out is not a plot without trees") {
  const silvafit::test::ScratchFile file(
      "plot,tree,species,x,y,dbh\n1,1,A,1,1,10\n2,1,A,1,1,-1\n2,2,A,1,1,-1\n", ".csv");
  const Inventory stand = read_inventory(file.path(), {.trust_units = true}).inventory;
  CHECK(stand.plots_left_out == std::vector<std::string>{"2"});
  const Window square = Window::rectangle({0, 0}, {10, 10});
  const StandReportOptions by_window{
      .units = {.neighbors = 1, .windows = {{"1", square}, {"2", square}}}};
  const StandReportOptions by_area{.units = {.neighbors = 1}, .plot_area_m2 = 100.0};
  for (const StandReportOptions& options : {by_window, by_area}) {
    const StandReport report = stand_report(stand, options);
    CHECK(report.all.stems_per_ha == Approx(100.0).epsilon(1e-14));
    CHECK_THAT(notes_in(report), Contains("plot 2 is not counted: all its rows were left out"));
    CHECK_THAT(notes_in(report), !Contains("no tree"));
  }
}

TEST_CASE("a plot area stands in place of a window, and quadrats need one") {
  const Inventory stand = stand_of({{}, {.x = 10}, {.y = 10, .dbh_cm = 30}});
  StandReportOptions options{.units = {.neighbors = 1}, .plot_area_m2 = 500.0};
  options.units.further = {FurtherIndex::kBasalAreaLarger};
  const StandReport report = stand_report(stand, options);
  CHECK(report.units->further[0].values[0] == Approx(basal_m2(30) / 0.05).epsilon(1e-14));
  CHECK_THAT(notes_in(report), !Contains("BAL"));
  options.species.quadrat_m = 5.0;
  CHECK_THROWS_WITH(stand_report(stand, options), Contains("--plot-area gives none"));
  options.units.windows = {{kEveryPlot, Window::circle({0, 0}, 12.0)}};
  CHECK_THROWS_WITH(stand_report(stand, options),
                    Contains("give --plot-area, or --window or --circle"));
}

TEST_CASE("thickest trees without a height are said, by plot") {
  // 100 a hectare are two on 200 m2.
  Inventory stand = stand_of({{.dbh_cm = 40, .h_m = NAN},
                              {.dbh_cm = 30, .h_m = 20},
                              {.dbh_cm = 20, .h_m = 15},
                              {.dbh_cm = 20, .plot = "2", .h_m = 15}});
  const StandReport report = stand_report(stand, {.plot_area_m2 = 200.0});
  const StandFigures& first = report.areas[0].figures;
  CHECK(first.dominant_height_m == 20.0);
  CHECK(first.dominant_trees == 2);
  CHECK(first.dominant_trees_without_height == 1);
  CHECK_THAT(notes_in(report), Contains("mean of the others: 1 (1 of 2); silvafit impute"));
  stand.h_m[0] = 22.0;
  CHECK_THAT(notes_in(stand_report(stand, {.plot_area_m2 = 200.0})), !Contains("thickest"));
  stand.h_m.clear();
  CHECK_THAT(notes_in(stand_report(stand, {.plot_area_m2 = 200.0})), !Contains("thickest"));
}
