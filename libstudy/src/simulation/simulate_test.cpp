// SPDX-License-Identifier: MIT
// Simulated stands against the theory of their design. Bounds of 4 standard errors: with the
// fixed seed the result is always the same; one of 16,000 other seeds would fail.
#include "silvafit/study/simulate.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "simulation/simulation_test_support.hpp"

using namespace silvafit;
using nlohmann::json;
using test::check_standard_normal;
using test::mean;
using test::plain_design;
using test::stand_of;
using test::variance;

namespace {

std::string csv_of(const study::SimulatedStand& stand) {
  std::ostringstream stream;
  data::write_csv_table(stand::to_table(stand.inventory), stream);
  return stream.str();
}

bool is_multiple(double value, double per_unit) {
  return value == std::round(value * per_unit) / per_unit;
}

}  // namespace

TEST_CASE("the bytes depend on the design and the seed only") {
  const study::SimulationDesign design = study::parse_design(plain_design().dump(), "");
  const study::SimulatedStand one_thread = study::simulate(design, 7, 1);
  const study::SimulatedStand two_threads = study::simulate(design, 7, 2);
  CHECK(csv_of(one_thread) == csv_of(two_threads));
  CHECK(study::truth_json(design, one_thread, 7) == study::truth_json(design, two_threads, 7));
  CHECK(csv_of(one_thread) != csv_of(study::simulate(design, 8)));
}

TEST_CASE("stems have the minimum distance and the density of the design, inside their plots") {
  const stand::Inventory trees = stand_of(plain_design()).inventory;
  CHECK(trees.size() == 3000);
  double nearest = 1e9;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, std::hypot(trees.x[i] - trees.x[j], trees.y[i] - trees.y[j]));
    }
    const std::size_t plot = std::stoul(std::string(trees.plot[i])) - 1;
    const std::size_t row = plot / 2;
    const double x0 = 50.0 * static_cast<double>(plot % 2);
    const double y0 = 50.0 * static_cast<double>(row);
    CHECK((trees.x[i] >= x0 && trees.x[i] <= x0 + 50.0));
    CHECK((trees.y[i] >= y0 && trees.y[i] <= y0 + 50.0));
  }
  CHECK(nearest >= 0.7);
}

TEST_CASE("patchiness increases the variance of counts in quadrats") {
  const auto dispersion = [](double patchiness) {
    json design = plain_design();
    design["stems"]["minimum_distance"] = 0;
    design["species"][0]["patchiness"] = patchiness;
    const stand::Inventory trees = stand_of(design).inventory;
    std::vector<double> counts(100, 0.0);
    for (std::size_t i = 0; i < trees.size(); ++i) {
      const auto column = static_cast<std::size_t>(std::min(9.0, trees.x[i] / 10.0));
      const auto row = static_cast<std::size_t>(std::min(9.0, trees.y[i] / 10.0));
      counts[10 * row + column] += 1.0;
    }
    return variance(counts) / mean(counts);
  };
  // Index of dispersion of a Poisson process: 1, standard error sqrt(2 / (quadrats - 1)).
  CHECK(std::abs(dispersion(0.0) - 1.0) < 4.0 * std::sqrt(2.0 / 99.0));
  CHECK(dispersion(0.8) > 4.0);
}

TEST_CASE("DBH has the mean and standard deviation of the design") {
  json design = plain_design();
  design["plots"]["grid"] = {{"columns", 20}, {"rows", 20}, {"width", 10}, {"height", 10}};
  design["species"][0]["density"] = 4000;
  design["stems"]["minimum_distance"] = 0;
  double plot_log_sd = 0.0;
  SECTION("without variance between plots") {}
  SECTION("with variance between plots") { plot_log_sd = 0.2; }
  design["species"][0]["dbh"]["plot_log_sd"] = plot_log_sd;
  const study::SimulatedStand stand = stand_of(design);
  const std::vector<double>& dbh = stand.inventory.dbh_cm;
  const auto n = static_cast<double>(dbh.size());
  const double plots = 400.0;
  const double plot_sd = 19.86 * std::sqrt(std::expm1(plot_log_sd * plot_log_sd));
  const double se = std::sqrt(8.91 * 8.91 / n + plot_sd * plot_sd / plots);
  CHECK(std::abs(mean(dbh) - 24.86) < 4.0 * se);
  // A gamma variate of shape k has kurtosis 3 + 6/k; the factor of plots changes that little.
  const double kurtosis = 3.0 + 6.0 / std::pow(19.86 / 8.91, 2);
  const double se_sd = 8.91 * 0.5 * std::sqrt((kurtosis - 1.0) / n + plot_log_sd * 0.02);
  CHECK(std::abs(std::sqrt(variance(dbh)) - 8.91) < 4.0 * se_sd);
  CHECK(*std::min_element(dbh.begin(), dbh.end()) >= 5.0);

  const std::vector<double>& factors = stand.species[0].dbh_plot_factor;
  REQUIRE(factors.size() == 400);
  CHECK(std::abs(mean(factors) - 1.0) <= 4.0 * plot_sd / 19.86 / std::sqrt(plots));
}

TEST_CASE("random effects of many plots have the covariance of the design") {
  json design = plain_design();
  design["plots"]["grid"] = {{"columns", 50}, {"rows", 50}, {"width", 10}, {"height", 10}};
  design["species"][0]["density"] = 100;
  design["species"][0]["h"] = {
      {"formula", "h ~ a + b*dbh"},
      {"parameters", {"b ~ 1 + C"}},
      {"fixed", {{"a", 30}, {"b", 0.5}, {"b:C", 0.1}}},
      {"random",
       {{"effects", {"a", "b", "b:C"}},
        {"variance", {4.99, 7.51e-5, 2.90e-5}},
        {"correlation", {{1, -0.986, 0.883}, {-0.986, 1, -0.947}, {0.883, -0.947, 1}}}}},
      {"sigma", 1}};
  const study::SimulationDesign parsed = study::parse_design(design.dump(), "");
  const Eigen::MatrixXd truth = parsed.species[0].h.random_covariance;
  CHECK(truth(0, 1) == Approx(-0.986 * std::sqrt(4.99 * 7.51e-5)).epsilon(1e-12));
  const Eigen::MatrixXd effects = study::simulate(parsed, 1).species[0].h.random_effects;
  const double plots = 2500.0;
  REQUIRE(effects.rows() == 2500);
  const Eigen::RowVectorXd center = effects.colwise().mean();
  const Eigen::MatrixXd centered = effects.rowwise() - center;
  const Eigen::MatrixXd covariance = centered.transpose() * centered / (plots - 1.0);
  for (Eigen::Index i = 0; i < 3; ++i) {
    CHECK(std::abs(center[i]) < 4.0 * std::sqrt(truth(i, i) / plots));
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double se = std::sqrt((truth(i, i) * truth(j, j) + truth(i, j) * truth(i, j)) / plots);
      CHECK(std::abs(covariance(i, j) - truth(i, j)) < 4.0 * se);
    }
  }
}

TEST_CASE("residuals have the standard deviation of the variance function") {
  json variance_function;
  double (*spread)(double) = nullptr;
  SECTION("none") {
    variance_function = {{"function", "none"}};
    spread = [](double) { return 1.0; };
  }
  SECTION("exponential") {
    variance_function = {{"function", "exponential"}, {"delta", 0.03}};
    spread = [](double v) { return std::exp(0.03 * v); };
  }
  SECTION("power") {
    variance_function = {{"function", "power"}, {"delta", 0.6}};
    spread = [](double v) { return std::pow(v, 0.6); };
  }
  SECTION("constant plus power") {
    variance_function = {{"function", "constant-plus-power"}, {"delta", 0.5}, {"constant", 1}};
    spread = [](double v) { return 1.0 + std::sqrt(v); };
  }
  json design = plain_design();
  design["species"][0]["h"]["variance"] = variance_function;
  const study::SimulatedStand stand = stand_of(design);
  const double sigma = stand.species[0].h.sigma;
  CHECK(sigma == 1.0);
  std::vector<double> low;
  std::vector<double> high;
  for (std::size_t i = 0; i < stand.inventory.size(); ++i) {
    const double fitted = 30.0 + 0.5 * stand.inventory.dbh_cm[i];
    const double standardized = (stand.inventory.h_m[i] - fitted) / (sigma * spread(fitted));
    (stand.inventory.dbh_cm[i] < 23.0 ? low : high).push_back(standardized);
  }
  CHECK(stand.species[0].h.redrawn == 0);
  check_standard_normal(low);
  check_standard_normal(high);
}

TEST_CASE("the residuals have the requested root mean square") {
  json design = plain_design();
  json& height = design["species"][0]["h"];
  height.erase("sigma");
  height["residual_rms"] = 2.2;
  height["variance"] = {{"function", "power(dbh)"}, {"delta", 0.5}};
  const study::SimulatedStand stand = stand_of(design);
  double sum = 0.0;
  for (std::size_t i = 0; i < stand.inventory.size(); ++i) {
    sum += std::pow(stand.inventory.h_m[i] - 30.0 - 0.5 * stand.inventory.dbh_cm[i], 2);
  }
  const double rms = std::sqrt(sum / static_cast<double>(stand.inventory.size()));
  // The relative standard error of an rms is about 1 / sqrt(2 n), somewhat more as the sds differ.
  CHECK(rms == Approx(2.2).epsilon(4.0 * 1.3 / std::sqrt(2.0 * 3000.0)));
}

TEST_CASE("crown widths are those for the C of the file") {
  json design = plain_design();
  design["species"][0]["cw"] = {
      {"formula", "cw ~ a + b*dbh"},
      {"parameters", {"a ~ 1 + C + M + U + W"}},
      {"fixed", {{"a", 0.9}, {"a:C", 0.8}, {"a:M", 0.3}, {"a:U", -0.2}, {"a:W", 0.1}, {"b", 0.02}}},
      {"sigma", 0.1}};
  design["species"][0]["density"] = 1500;
  design["species"].push_back(design["species"][0]);
  design["species"][1]["code"] = "B";
  const study::SimulatedStand stand = stand_of(design);
  CHECK(stand.crowding_unsettled == 0);
  CHECK(stand.crowding_passes > 1);
  const stand::Inventory& trees = stand.inventory;
  const stand::StructuralUnits units = stand::structural_units(
      trees, {.edge = stand::EdgeCorrection::kNone, .scope = stand::SearchScope::kStand});
  std::vector<double> residuals;
  std::vector<double> crowded;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const double fitted = 0.9 + 0.8 * units.C[i] + 0.3 * units.M[i] - 0.2 * units.U[i] +
                          0.1 * units.W[i] + 0.02 * trees.dbh_cm[i];
    residuals.push_back((trees.cw_m[i] - fitted) / 0.1);
    if (units.C[i] > 0.5) crowded.push_back(residuals.back());
    CHECK(trees.cw_m[i] ==
          Approx(0.5 * (trees.cr_e_m[i] + trees.cr_w_m[i] + trees.cr_s_m[i] + trees.cr_n_m[i]))
              .epsilon(1e-14));
  }
  check_standard_normal(residuals);
  // With another C than that of the file, some fitted values would be off by 0.2 and more.
  CHECK(*std::max_element(residuals.begin(), residuals.end()) < 5.0);
  CHECK(*std::min_element(residuals.begin(), residuals.end()) > -5.0);
  CHECK(crowded.size() > 100);
}

TEST_CASE("trees whose crown and C do not converge are counted") {
  json design = plain_design();
  design["species"][0]["cw"]["parameters"] = {"a ~ 1 + C"};
  design["species"][0]["cw"]["fixed"] = {{"a", 2.5}, {"a:C", -0.3}, {"b", 0.02}};
  const study::SimulatedStand stand = stand_of(design);
  CHECK(stand.crowding_passes == 200);
  CHECK(stand.crowding_unsettled > 0);
  CHECK(stand.crowding_unsettled < stand.inventory.size() / 2);
}

TEST_CASE("values are rounded as measured and within limits, also for implausible designs") {
  json design = plain_design();
  design["species"][0]["h"]["fixed"] = {{"a", -3}, {"b", 0.2}};
  design["species"][0]["hcb"]["fixed"] = {{"a", 1.0}};
  design["species"][0]["cw"]["fixed"] = {{"a", -1}, {"b", 0.05}};
  design["terrain"] = {{"base", 100}, {"slope_east", 0.1}, {"hill_sd", 3}, {"plot_sd", 1}};
  const study::SimulatedStand stand = stand_of(design);
  const stand::Inventory& trees = stand.inventory;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    CHECK(trees.h_m[i] >= 2.0);
    CHECK(trees.hcb_m[i] >= 0.15);
    CHECK(trees.hcb_m[i] < trees.h_m[i]);
    CHECK(trees.cw_m[i] >= 0.38);
    CHECK((is_multiple(trees.dbh_cm[i], 10) && is_multiple(trees.h_m[i], 10)));
    CHECK((is_multiple(trees.hcb_m[i], 10) && is_multiple(trees.cr_n_m[i], 100)));
    CHECK((is_multiple(trees.x[i], 100) && is_multiple(trees.z[i], 100)));
  }
  CHECK(stand.species[0].h.clamped > 0);
  CHECK(stand.species[0].cw.clamped > 0);
}

TEST_CASE("the inventory reader accepts every simulated tree") {
  const auto path = std::filesystem::temp_directory_path() / "silvafit-simulate-test.csv";
  const study::SimulatedStand stand = stand_of(plain_design());
  write_file(path, csv_of(stand));
  const stand::CheckedInventory read = stand::read_inventory(path);
  std::filesystem::remove(path);
  CHECK(read.excluded.empty());
  CHECK(read.inventory.size() == stand.inventory.size());
  CHECK(read.inventory.cw_m == stand.inventory.cw_m);
}

namespace {

/// Equal except for the last digits of numbers, which depend on the processor's instructions.
void check_same(const nlohmann::json& a, const nlohmann::json& b) {
  if (a.is_number_float() && b.is_number_float()) {
    CHECK(a.get<double>() == Approx(b.get<double>()).epsilon(1e-12));
    return;
  }
  REQUIRE(a.type() == b.type());
  REQUIRE(a.size() == b.size());
  if (a.is_object()) {
    for (const auto& [key, value] : a.items()) check_same(value, b.at(key));
  } else if (a.is_array()) {
    for (std::size_t i = 0; i < a.size(); ++i) check_same(a[i], b[i]);
  } else {
    CHECK(a == b);
  }
}

}  // namespace

TEST_CASE("the example is drawn from its design") {
  const std::filesystem::path folder = test::source_file("examples/fir-mixed");
  const study::SimulationDesign design = study::read_design(folder / "design.json");
  const study::SimulatedStand stand = study::simulate(design, 1);
  CHECK(stand.crowding_unsettled == 0);
  // Not CHECK(a == b), which would print both files.
  const bool same_inventory = csv_of(stand) == read_file(folder / "inventory.csv");
  CHECK(same_inventory);
  check_same(nlohmann::json::parse(study::truth_json(design, stand, 1)),
             nlohmann::json::parse(read_file(folder / "truth.json")));
}

TEST_CASE("limits that determine many values give a note") {
  json design = plain_design();
  const auto notes_in = [&design] {
    const study::SimulationDesign read = study::parse_design(design.dump(), "");
    return study::notes_on_limits(read, study::simulate(read, 3));
  };
  CHECK(notes_in().empty());
  // Below the lowest height by more than any residual.
  design["species"][0]["h"] = {
      {"formula", "h ~ a + b*dbh"}, {"fixed", {{"a", -500.0}, {"b", 0.0}}}, {"sigma", 0.1}};
  const std::vector<std::string> notes = notes_in();
  REQUIRE_FALSE(notes.empty());
  CHECK_THAT(notes[0], Catch::StartsWith("h of ") && Catch::Contains("trees reached a limit"));
}
