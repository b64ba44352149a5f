// SPDX-License-Identifier: MIT
// Studies of sampled plots: expansion factors, and neighborhoods where they are complete.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <string>

#include "silvafit/study/whole_study.hpp"
#include "study/study_tables.hpp"
#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

constexpr std::size_t kSampledPlots = 8;
constexpr double kInner = 4.0;
constexpr double kOuter = 8.0;

/// The trees per ha that a tree stands for: below 15 cm it is counted up to 4 m, else up to 8 m.
double factor_of(double dbh_cm) {
  const double radius_m = dbh_cm < 15.0 ? kInner : kOuter;
  return 1e4 / (std::numbers::pi * radius_m * radius_m);
}

/// Positions from the center of each plot; all trees are within their circle.
std::string sampled_csv() {
  Random random(3);
  std::string text = "plot,tree,x,y,species,dbh,h\n";
  for (std::size_t plot = 1; plot <= kSampledPlots; ++plot) {
    const double limit = random.normal(25.0, 2.0);
    for (std::size_t tree = 1; tree <= 40; ++tree) {
      const double dbh = std::round(random.uniform(8.0, 40.0) * 10.0) / 10.0;
      const double radius = (dbh < 15.0 ? kInner : kOuter) * 0.99 * std::sqrt(random.uniform(0, 1));
      const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
      const double h = 1.3 + limit * (1.0 - std::exp(-0.05 * dbh)) + random.normal(0.0, 0.6);
      text += fmt::format("{},{},{:.2f},{:.2f},{},{:.1f},{:.2f}\n",
                          plot,
                          tree,
                          radius * std::cos(angle),
                          radius * std::sin(angle),
                          tree % 4 == 0 ? "B" : "A",
                          dbh,
                          h);
    }
  }
  return text;
}

data::TableSource sampled_source(const std::string& text) {
  return std::make_shared<const data::TableText>(
      data::TableText{.name = "sampled.csv", .text = text, .separator = ','});
}

StudyRecord study_with_edge(stand::EdgeCorrection edge) {
  StudyConfiguration settings;
  settings.study.species = {"A"};
  settings.study.responses = {"h"};
  settings.study.candidates["h"] = {"h ~ 1.3 + a*(1 - exp(-b*dbh))"};
  settings.study.variance_functions = {"none"};
  settings.study.covariates = {"U", "stems_per_ha"};
  settings.study.minimum_trees = 20;
  settings.sampling.circles = {"7=4", "15=8"};
  settings.units.edge = edge;
  return whole_study(sampled_source(sampled_csv()), test::catalogue(), settings);
}

/// The trees per ha of each plot, by the definition.
std::map<std::string, double> stems_by_plot(const stand::Inventory& inventory) {
  std::map<std::string, double> stems;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    stems[std::string(inventory.plot[tree])] += factor_of(inventory.dbh_cm[tree]);
  }
  return stems;
}

}  // namespace

TEST_CASE("figures of sampled plots have the expansion factors of their trees") {
  const StudyRecord record = study_with_edge(stand::EdgeCorrection::kHanisch);
  const stand::Inventory& inventory = record.inventory.inventory;
  const auto stems = stems_by_plot(inventory);
  const std::span<const double> column = record.table.numbers("stems_per_ha");
  double of_all = 0.0;
  for (const auto& [plot, value] : stems) of_all += value / static_cast<double>(kSampledPlots);
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    CHECK(column[tree] == Approx(stems.at(std::string(inventory.plot[tree]))).epsilon(1e-12));
  }
  // The table of species: density per ha of both species together.
  const FormattedTable species = species_importance_table(record);
  double density = 0.0;
  for (const TableRow& row : species.rows) density += std::get<double>(row[2]);
  CHECK(density == Approx(of_all).epsilon(1e-12));
  CHECK(record.decisions.front().second == "circles 7=4, 15=8");
}

TEST_CASE("core trees of sampled plots are where all counted trees are known") {
  const StudyRecord record = study_with_edge(stand::EdgeCorrection::kHanisch);
  REQUIRE(record.units);
  const stand::Inventory& inventory = record.inventory.inventory;
  std::size_t core = 0;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    if (record.units->core[tree] == 0) continue;
    ++core;
    CHECK(std::hypot(inventory.x[tree], inventory.y[tree]) < kInner);
  }
  CHECK(core > 0);
  REQUIRE(record.study.results.size() == 1);
  for (const std::size_t row : record.study.results.front().rows) {
    CHECK(record.units->core[row] != 0);
  }
}

TEST_CASE("without core trees a study skips structural units and uses all trees") {
  // A buffer of 5 m leaves nothing of a circle of 4 m.
  const StudyRecord record = study_with_edge(stand::EdgeCorrection::kBuffer);
  CHECK_FALSE(record.units);
  CHECK_THAT(record.sample->notes.back(), Contains("structural units are skipped"));
  REQUIRE(record.study.results.size() == 1);
  CHECK(record.study.results.front().rows.size() == kSampledPlots * 30);
  CHECK(record.table.has("stems_per_ha"));
}
