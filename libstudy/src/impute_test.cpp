// SPDX-License-Identifier: MIT
#include "silvafit/study/impute.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
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

Catalogue catalogue() {
  return Catalogue::load(std::filesystem::path(SILVAFIT_DATA_DIR) / "models");
}

/// The fit's curve with effects of a plot added, written out.
double curve(const fit::FittedModel& fit, const std::string& plot, double dbh) {
  Eigen::VectorXd coefficients = fit.estimate;
  for (std::size_t g = 0; g < fit.group_labels.size(); ++g) {
    if (fit.group_labels[g] == plot) {
      coefficients += fit.random_effects.col(static_cast<Eigen::Index>(g));
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
  REQUIRE(fit.random_names.size() == 2);
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
    // Only rounding is between the two.
    CHECK(result.value[row] == Approx(curve(fit, plot, table.numbers("dbh")[row])).epsilon(1e-12));
  }
  CHECK(result.source[1] == ImputeSource::kMissing);
  CHECK(result.flag[1] == "dbh is missing");
  CHECK(result.flag[2] == "dbh is outside the fitted range");
  CHECK(std::isnan(result.value[1]));
  CHECK(result.count(ImputeLevel::kPopulation) == kTrees);
  CHECK(result.count(ImputeSource::kMissing) == 1);
}

TEST_CASE("species with enough trees have models of their own, the others share one") {
  const data::Table table = inventory();
  const Imputation result = impute(table, catalogue(), {.by = "species", .minimum_trees = 50});
  REQUIRE(result.models.size() == 2);
  CHECK(result.models[0].label == "pine");
  CHECK(result.models[1].label.empty());
  CHECK(result.models[1].fit.observations > result.models[0].fit.observations);
  CHECK(result.count(ImputeSource::kMissing) == 1);
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

TEST_CASE("several models are tried, and the one with the lowest AIC is taken") {
  const data::Table table = inventory();
  const Imputation m1 = impute(table, catalogue(), {.models = {"M1"}});
  const Imputation m2 = impute(table, catalogue(), {.models = {"M2"}});
  const Imputation both = impute(table, catalogue(), {.models = {"M1", "M2"}});
  const double best = std::min(m1.models[0].fit.aic(), m2.models[0].fit.aic());
  CHECK(both.models[0].fit.aic() == best);
}

TEST_CASE("imputation says what it lacks") {
  data::Table table = inventory();
  CHECK_THROWS_WITH(impute(table, catalogue(), {.response = "volume"}),
                    Contains("there is no column 'volume'"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.by = "kind"}), Contains("no column 'kind'"));
  CHECK_THROWS_WITH(impute(table, catalogue(), {.formula = "dbh ~ p + q*h"}), Contains("not of h"));
  table.set("h", std::vector<double>(table.rows(), kNaN));
  CHECK_THROWS_AS(impute(table, catalogue()), InputError);
}
