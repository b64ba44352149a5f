// SPDX-License-Identifier: MIT
#include "silvafit/study/impute.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

constexpr int kPlots = 12;
constexpr int kTrees = 30;

/// Heights by Naslund's curve with plots that differ, a third of them measured, none in plot P12.
/// Two trees of plot P1 are special: the first has no dbh, the second one far outside the range.
data::Table inventory() {
  Random random(17);
  data::Table table;
  data::TextColumn plot;
  data::TextColumn species;
  std::vector<double> dbh;
  std::vector<double> h;
  for (int i = 1; i <= kPlots; ++i) {
    const double a = 0.2 + random.normal(0.0, 0.015);
    for (int j = 0; j < kTrees; ++j) {
      plot.append("P" + std::to_string(i));
      species.append(j % 10 == 9 ? "rare" : "pine");
      const double d = random.uniform(6.0, 40.0);
      const double height = 1.3 + d * d / std::pow(a * d + 1.2, 2) + random.normal(0.0, 0.5);
      dbh.push_back(d);
      h.push_back(j % 3 == 0 && i < kPlots ? height : kNaN);
    }
  }
  dbh[1] = kNaN;
  dbh[2] = 90.0;
  table.set("plot", plot);
  table.set("species", species);
  table.set("dbh", dbh);
  table.set("h", h);
  return table;
}

Catalogue catalogue() { return Catalogue::load(silvafit::test::data_file("models")); }

constexpr int kMeasuredStands = 50;
constexpr int kFewTrees = 8;

/// 50 stands S1... with heights of half of their trees, but none on the last of several plots, and
/// some stands S5... without heights; heights are a line with effects of stand and plot.
/// With several plots a stand these are numbered from 1 in each, else they have the stand's name.
data::Table linear_inventory(int unmeasured_stands, int plots_a_stand) {
  Random random(23);
  data::Table table;
  data::TextColumn stand;
  data::TextColumn plot;
  std::vector<double> dbh;
  std::vector<double> h;
  for (int i = 0; i < kMeasuredStands + unmeasured_stands; ++i) {
    const bool is_measured = i < kMeasuredStands;
    const std::string name = (is_measured ? "S1" : "S5") + std::to_string(1000 + i);
    const double of_stand = random.normal(0.0, 2.0);
    for (int j = 1; j <= plots_a_stand; ++j) {
      const double of_plot = plots_a_stand > 1 ? random.normal(0.0, 1.5) : 0.0;
      const bool has_heights = is_measured && (j < plots_a_stand || plots_a_stand == 1);
      for (int k = 0; k < kFewTrees; ++k) {
        stand.append(name);
        plot.append(plots_a_stand > 1 ? std::to_string(j) : name);
        dbh.push_back(random.uniform(6.0, 40.0));
        const double height = 5.0 + 0.5 * dbh.back() + of_stand + of_plot + random.normal(0.0, 1.0);
        h.push_back(has_heights && k % 2 == 0 ? height : kNaN);
      }
    }
  }
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("dbh", dbh);
  table.set("h", h);
  return table;
}

/// Mean difference of the imputed values of two imputations by the values of a column.
std::map<std::string, double> mean_differences(const data::Table& table,
                                               const std::string& column,
                                               const Imputation& first,
                                               const Imputation& second) {
  const data::TextColumn labels = table.labels(column);
  std::map<std::string, double> sums;
  std::map<std::string, int> counts;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (first.source[row] != ImputeSource::kImputed) continue;
    sums[std::string(labels[row])] += second.value[row] - first.value[row];
    ++counts[std::string(labels[row])];
  }
  for (auto& [label, sum] : sums) sum /= counts[label];
  return sums;
}

template <typename Choice>
double mean_square(const std::map<std::string, double>& values, const Choice& is_chosen) {
  double sum = 0.0;
  int count = 0;
  for (const auto& [label, value] : values) {
    if (!is_chosen(label)) continue;
    sum += value * value;
    ++count;
  }
  return sum / count;
}

/// The fit's curve with effects of a plot added, written out.
double curve(const fit::FittedModel& fit, const std::string& plot, double dbh) {
  Eigen::VectorXd coefficients = fit.estimate;
  for (std::size_t g = 0; g < fit.random.back().labels.size(); ++g) {
    if (fit.random.back().labels[g] == plot) {
      coefficients += fit.random.back().effects.col(static_cast<Eigen::Index>(g));
    }
  }
  return 1.3 + dbh * dbh / std::pow(coefficients[0] * dbh + coefficients[1], 2);
}

}  // namespace

TEST_CASE("heights are imputed with the effects of their plot, measured ones are kept") {
  const data::Table table = inventory();
  const Imputation result = impute(table, catalogue());
  REQUIRE(result.models.size() == 1);
  const fit::FittedModel& fit = result.models[0].fit;
  CHECK(fit.model == "M1");
  CHECK(fit.specification.variance.text() == "power(dbh)");
  REQUIRE(fit.random.back().names.size() == 2);
  const data::TextColumn plots = table.labels("plot");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double measured = table.numbers("h")[row];
    if (!std::isnan(measured)) {
      CHECK(result.source[row] == ImputeSource::kMeasured);
      CHECK(result.value[row] == measured);
      continue;
    }
    if (row == 1) continue;
    const std::string plot(plots[row]);
    CHECK(result.source[row] == ImputeSource::kImputed);
    CHECK((result.level[row] == ImputeLevel::kPopulation) == (plot == "P12"));
    // The two differ by rounding only.
    CHECK(result.value[row] == Approx(curve(fit, plot, table.numbers("dbh")[row])).epsilon(1e-12));
  }
  CHECK(result.source[1] == ImputeSource::kMissing);
  CHECK(result.flag[1] == "dbh is missing");
  CHECK(result.flag[2] == "dbh is outside the fitted range");
  CHECK(std::isnan(result.value[1]));
  CHECK(result.count(ImputeLevel::kPopulation) == kTrees);
  CHECK(result.count(ImputeSource::kMissing) == 1);
}

TEST_CASE("a label without a measured tree is flagged") {
  data::Table table;
  std::vector<double> dbh;
  std::vector<double> h;
  data::TextColumn soil;
  for (int i = 0; i < 60; ++i) {
    dbh.push_back(10.0 + i % 20);
    h.push_back(i == 7 || i == 8 ? NAN : 3.0 + 0.8 * dbh.back() + std::sin(7.0 * i * i));
    soil.append(i == 7 ? "bog" : (i % 3 == 0 ? "clay" : "sand"));
  }
  table.set("dbh", dbh);
  table.set("h", h);
  table.set("soil", soil);
  const Imputation result =
      impute(table, catalogue(), {.formula = R"(h ~ a + d*(soil == "clay") + b*dbh)"});
  CHECK(result.flag[7] == "soil is not in the fit");
  CHECK(result.flag[8].empty());
  CHECK(std::isfinite(result.value[7]));
}

TEST_CASE("species with enough trees have separate models, the others share one") {
  const data::Table table = inventory();
  const Imputation result = impute(table, catalogue(), {.by = "species", .minimum_trees = 50});
  REQUIRE(result.models.size() == 2);
  CHECK(result.models[0].label == "pine");
  CHECK(result.models[1].label.empty());
  CHECK(result.models[1].fit.observations > result.models[0].fit.observations);
  CHECK(result.count(ImputeSource::kMissing) == 1);
}

TEST_CASE("a species of which no model converges shares the model of all") {
  data::Table table = inventory();
  data::TextColumn species;
  for (std::size_t row = 0; row < table.rows(); ++row) species.append(row == 0 ? "yew" : "pine");
  table.set("species", species);
  const Imputation result = impute(table, catalogue(), {.by = "species", .minimum_trees = 1});
  REQUIRE(result.models.size() == 2);
  CHECK(result.models[0].label == "pine");
  CHECK(result.models[1].label.empty());
  CHECK(std::ranges::any_of(result.notes, [](const std::string& note) {
    return note.starts_with("yew: ") && note.ends_with("the model for all trees is used");
  }));
}

TEST_CASE("residuals that are added have the fit's standard deviation and follow the seed") {
  const data::Table table = inventory();
  const Imputation plain = impute(table, catalogue());
  const Imputation first = impute(table, catalogue(), {.add_residual = true, .seed = 2});
  const Imputation again = impute(table, catalogue(), {.add_residual = true, .seed = 2});
  const Imputation other = impute(table, catalogue(), {.add_residual = true, .seed = 3});
  const fit::FittedModel& fit = plain.models[0].fit;
  double squares = 0.0;
  int count = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (plain.level[row] != ImputeLevel::kPlot) continue;
    const double deviation = fit.sigma * std::pow(table.numbers("dbh")[row], fit.variance.delta());
    squares += std::pow((first.value[row] - plain.value[row]) / deviation, 2);
    CHECK(first.value[row] == again.value[row]);
    CHECK(first.value[row] != other.value[row]);
    ++count;
  }
  // The mean square of n standard normal numbers has a standard deviation of sqrt(2/n).
  CHECK(squares / count == Approx(1.0).margin(4.0 * std::sqrt(2.0 / count)));
}

TEST_CASE("a residual that makes a crown base impossible is drawn anew") {
  // Crown bases near the ground, of which a residual of 0.5 m would put every fourth below it.
  Random random(4);
  data::Table table;
  std::vector<double> h;
  std::vector<double> hcb;
  for (int i = 0; i < 600; ++i) {
    h.push_back(random.uniform(2.0, 4.0));
    const double base = 0.1 * h.back() + random.normal(0.0, 0.5);
    hcb.push_back(i % 3 == 0 && base >= 0.0 && base < h.back() ? base : kNaN);
  }
  table.set("h", h);
  table.set("hcb", hcb);
  const Imputation result = impute(table,
                                   catalogue(),
                                   {.response = "hcb",
                                    .formula = "hcb ~ a + b*h",
                                    .random = "none",
                                    .variance = "none",
                                    .add_residual = true});
  CHECK(result.count(ImputeSource::kMissing) == 0);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    CHECK((result.value[row] >= 0.0 && result.value[row] < h[row]));
  }
}

TEST_CASE("a species without a measured tree is flagged, since it has the curve of others") {
  data::Table table = inventory();
  std::vector<double> h(table.numbers("h").begin(), table.numbers("h").end());
  const data::TextColumn species = table.labels("species");
  for (std::size_t row = 0; row < h.size(); ++row) {
    if (species[row] == "rare") h[row] = kNaN;
  }
  table.set("h", h);
  const Imputation result = impute(table, catalogue(), {.by = "species"});
  for (std::size_t row = 0; row < h.size(); ++row) {
    const bool is_flagged = result.flag[row] == "no tree of its species is measured";
    CHECK(is_flagged == (species[row] == "rare"));
  }
}

TEST_CASE("plots without measured trees get random effects drawn from their distribution") {
  constexpr int kUnmeasured = 400;
  const data::Table table = linear_inventory(kUnmeasured, 1);
  ImputeOptions options{
      .formula = "h ~ p + q*dbh", .random = "p | plot", .variance = "none", .seed = 5};
  const Imputation plain = impute(table, catalogue(), options);
  options.add_residual = true;
  const Imputation drawn = impute(table, catalogue(), options);
  const fit::FittedModel& fit = plain.models[0].fit;
  REQUIRE(fit.random.back().covariance(0, 0) > 1.0);
  const double residual = fit.sigma * fit.sigma / kFewTrees;
  // The mean square of n normal numbers has a relative standard deviation of sqrt(2/n).
  const auto by_plot = mean_differences(table, "plot", plain, drawn);
  const double unmeasured = mean_square(by_plot, [](const auto& plot) { return plot >= "S5"; });
  CHECK(unmeasured == Approx(fit.random.back().covariance(0, 0) + residual)
                          .epsilon(4.0 * std::sqrt(2.0 / kUnmeasured)));
  CHECK(drawn.count(ImputeLevel::kPopulation) == std::size_t{kUnmeasured} * kFewTrees);
  // Those of measured plots are not drawn; half of their trees are imputed.
  const double measured = mean_square(by_plot, [](const auto& plot) { return plot < "S5"; });
  CHECK(
      measured ==
      Approx(2.0 * residual).epsilon(4.0 * std::sqrt(2.0 / static_cast<double>(kMeasuredStands))));
}

TEST_CASE("nested groupings take the plot's effects, the stand's, or the population's") {
  constexpr int kUnmeasured = 400;
  const data::Table table = linear_inventory(kUnmeasured, 3);
  ImputeOptions options{
      .formula = "h ~ p + q*dbh", .random = "p | stand/plot", .variance = "none", .seed = 5};
  const Imputation plain = impute(table, catalogue(), options);
  const fit::FittedModel& fit = plain.models[0].fit;
  const data::TextColumn stands = table.labels("stand");
  const data::TextColumn plots = table.labels("plot");
  std::map<std::string, double> stand_effect;
  for (std::size_t c = 0; c < fit.random.front().labels.size(); ++c) {
    stand_effect[fit.random.front().labels[c]] =
        fit.random.front().effects(0, static_cast<Eigen::Index>(c));
  }
  REQUIRE(stand_effect.size() == kMeasuredStands);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (plain.source[row] == ImputeSource::kMeasured) continue;
    const std::string stand(stands[row]);
    const bool has_stand = stand < "S5";
    const bool has_plot = has_stand && plots[row] != "3";
    CHECK(word_of(plain.level[row]) == (has_plot ? "plot" : has_stand ? "stand" : "population"));
    if (has_plot) continue;
    const double mean = fit.estimate[0] + fit.estimate[1] * table.numbers("dbh")[row];
    // They differ by rounding only.
    CHECK(plain.value[row] ==
          Approx(mean + (has_stand ? stand_effect[stand] : 0.0)).epsilon(1e-12));
  }

  options.add_residual = true;
  const Imputation drawn = impute(table, catalogue(), options);
  const double residual = fit.sigma * fit.sigma / kFewTrees;
  const double expected =
      fit.random.front().covariance(0, 0) + (fit.random.back().covariance(0, 0) + residual) / 3.0;
  const double found = mean_square(mean_differences(table, "stand", plain, drawn),
                                   [](const auto& stand) { return stand >= "S5"; });
  CHECK(found == Approx(expected).epsilon(4.0 * std::sqrt(2.0 / kUnmeasured)));
}

TEST_CASE("too few plots for random effects give a note") {
  data::Table table = inventory();
  const Imputation with_plots = impute(table, catalogue());
  CHECK(with_plots.notes.empty());
  // Two plots, trees measured on one of them.
  std::vector<std::size_t> rows;
  const data::TextColumn plots = table.labels("plot");
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (plots[row] == "P3" || plots[row] == "P12") rows.push_back(row);
  }
  const Imputation one = impute(table.select(rows), catalogue());
  REQUIRE(one.notes.size() == 1);
  CHECK_THAT(one.notes[0], Contains("fewer than two values of 'plot'"));
  CHECK(one.count(ImputeLevel::kPlot) == 0);

  data::Table without;
  for (const std::string name : {"dbh", "h"}) {
    const auto values = table.numbers(name);
    without.set(name, std::vector<double>(values.begin(), values.end()));
  }
  const Imputation none = impute(without, catalogue());
  REQUIRE(none.notes.size() == 1);
  CHECK_THAT(none.notes[0], Contains("the column 'plot' is missing"));
  CHECK(none.count(ImputeLevel::kPlot) == 0);
  CHECK_THROWS_AS(impute(table, catalogue(), {.group = "plt"}), UsageError);
}

TEST_CASE("a method without random effects is used as it is") {
  // The least-squares line through (10, 8), (20, 13) and (30, 17) is 11/3 + 0.45 x.
  data::Table table;
  data::TextColumn plots;
  for (int row = 0; row < 4; ++row) plots.append("A");
  table.set("plot", plots);
  table.set("dbh", std::vector<double>{10.0, 20.0, 30.0, 40.0});
  table.set("h", std::vector<double>{8.0, 13.0, 17.0, data::kMissing});
  ImputeOptions options{.formula = "h ~ a + b*dbh"};
  options.method = fit::Method::kOrdinary;
  const Imputation line = impute(table, catalogue(), options);
  CHECK(line.value[3] == Approx(11.0 / 3.0 + 0.45 * 40.0).epsilon(1e-9));
}

TEST_CASE("of several models the one with the lowest AIC is used") {
  const data::Table table = inventory();
  const Imputation m1 = impute(table, catalogue(), {.models = {"M1"}});
  const Imputation m2 = impute(table, catalogue(), {.models = {"M2"}});
  const Imputation both = impute(table, catalogue(), {.models = {"M1", "M2"}});
  const double best = std::min(m1.models[0].fit.aic(), m2.models[0].fit.aic());
  CHECK(both.models[0].fit.aic() == best);
}

TEST_CASE("errors of imputation name the missing input") {
  data::Table table = inventory();
  CHECK_THROWS_WITH(impute(table, catalogue(), {.response = "volume"}),
                    Contains("unknown column 'volume'"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.by = "kind"}), Contains("unknown column 'kind'"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.formula = "dbh ~ p + q*h"}),
                    Contains("not for h"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.formula = "h ~ p + q*dbh", .models = {"M1"}}),
                    Contains("either `formula` or `models`"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.formula = "h ~ p + q*species"}),
                    Contains("'pine' is not a number"));
  table.set("h", std::vector<double>(table.rows(), kNaN));
  CHECK_THROWS_AS(impute(table, catalogue()), InputError);
}
