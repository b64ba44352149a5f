// SPDX-License-Identifier: MIT
// Studies of repeated measurements: every row is used, and each time has its own neighborhoods.
#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "silvafit/study/predict_responses.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/whole_study.hpp"
#include "study/study_tables.hpp"
#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

constexpr std::size_t kPlots = 6;
constexpr std::size_t kTrees = 16;

/// Trees on a grid of 2 m, measured in two years, and a row without a year. Heights differ between
/// plots by 2 m and between the years of a plot by 1.5 m (standard deviations).
std::string repeated_csv() {
  Random random(5);
  std::string text = "plot,tree,campaign,x,y,dbh,h\n";
  for (std::size_t plot = 1; plot <= kPlots; ++plot) {
    const double limit = random.normal(25.0, 2.0);
    std::vector<double> dbh(kTrees);
    for (double& each : dbh) each = random.uniform(8.0, 40.0);
    for (const int year : {2010, 2020}) {
      const double own = limit + random.normal(0.0, 1.5);
      for (std::size_t tree = 0; tree < kTrees; ++tree) {
        const double h = 1.3 + own * (1.0 - std::exp(-0.05 * dbh[tree])) + random.normal(0.0, 0.5);
        text += fmt::format("{},{},{},{},{},{:.1f},{:.2f}\n",
                            plot,
                            tree + 1,
                            year,
                            2 * (tree % 4),
                            2 * (tree / 4),
                            dbh[tree],
                            h);
        dbh[tree] += 2.0;
      }
    }
  }
  return text + "1,99,,1,1,20,18\n";
}

constexpr std::size_t kPlotsOfTrees = 8;
constexpr std::size_t kTreesOfPlot = 12;

/// Trees measured in three years. Heights differ between plots by 2 m and between the trees of a
/// plot by 1.5 m; errors are 0.5 m (standard deviations).
std::string trees_csv() {
  Random random(8);
  std::string text = "plot,tree,year,dbh,h\n";
  for (std::size_t plot = 1; plot <= kPlotsOfTrees; ++plot) {
    const double of_plot = random.normal(24.0, 2.0);
    for (std::size_t tree = 1; tree <= kTreesOfPlot; ++tree) {
      const double limit = of_plot + random.normal(0.0, 1.5);
      const double first = random.uniform(8.0, 35.0);
      for (const int year : {2000, 2005, 2010}) {
        const double dbh = first + 0.4 * (year - 2000);
        const double h = 1.3 + limit * (1.0 - std::exp(-0.05 * dbh)) + random.normal(0.0, 0.5);
        text += fmt::format("{},{},{},{:.1f},{:.2f}\n", plot, tree, year, dbh, h);
      }
    }
  }
  return text;
}

data::TableSource source_of(const std::string& text) {
  return std::make_shared<const data::TableText>(
      data::TableText{.name = "repeated.csv", .text = text, .separator = ','});
}

StudyConfiguration settings_of(const std::string& period) {
  StudyConfiguration settings;
  settings.study.responses = {"h"};
  settings.study.candidates["h"] = {"h ~ 1.3 + a*(1 - exp(-b*dbh))"};
  settings.study.variance_functions = {"none"};
  settings.study.covariates = {"U", "stems_per_ha"};
  settings.study.minimum_trees = 50;
  settings.study.period = period;
  settings.units.edge = stand::EdgeCorrection::kNone;
  settings.units.circle = "3,3,5";
  return settings;
}

const StudyRecord& repeated_study() {
  static const StudyRecord record =
      whole_study(source_of(repeated_csv()), test::catalogue(), settings_of("campaign"));
  return record;
}

const FormattedTable& table_named(const std::vector<FormattedTable>& tables,
                                  const std::string& name) {
  return *std::ranges::find(tables, name, &FormattedTable::name);
}

}  // namespace

TEST_CASE("a study with periods uses the rows of all times") {
  const StudyRecord& record = repeated_study();
  REQUIRE(record.study.results.size() == 1);
  const ResponseStudy& result = record.study.results.front();
  CHECK(result.rows.size() == 2 * kPlots * kTrees);
  CHECK(result.plots == kPlots);
  CHECK(record.table.labels("plot").levels().size() == kPlots);
  CHECK(record.table.labels("campaign").levels() == std::vector<std::string>{"2010", "2020"});
  REQUIRE(record.inventory.excluded.size() == 1);
  CHECK(record.inventory.excluded.front().reason == "the time of measurement is missing");
}

TEST_CASE("neighbors and figures of plots are those of one time") {
  const StudyRecord& record = repeated_study();
  const stand::Inventory& inventory = record.inventory.inventory;
  REQUIRE(record.units);
  const std::size_t n = record.units->neighbors;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    for (std::size_t k = 0; k < n; ++k) {
      const std::uint32_t neighbor = record.units->nearest[tree * n + k];
      CHECK(inventory.plot.code(neighbor) == inventory.plot.code(tree));
    }
  }
  // 16 trees in a circle of 5 m, not the 32 rows of its two years.
  const std::span<const double> stems = record.table.numbers("stems_per_ha");
  CHECK(stems[0] == Approx(16.0 * 1e4 / (25.0 * 3.14159265358979)).epsilon(1e-3));
}

TEST_CASE("periods are groups within the plots, which are left out as a whole") {
  const ResponseStudy& result = repeated_study().study.results.front();
  CHECK_THAT(result.chosen_terms(&ResponseStudy::random), Contains("| plot; "));
  CHECK_THAT(result.chosen_terms(&ResponseStudy::random), Contains("| plot/campaign"));
  REQUIRE(result.nlme);
  const fit::FittedModel& fit = result.nlme->fit;
  REQUIRE(fit.random.size() == 2);
  CHECK(fit.random.front().labels.size() == kPlots);
  CHECK(fit.random.back().labels.size() == 2 * kPlots);
  CHECK(fit.random.back().labels.front() == "1/2010");
  // The candidates of the plots alone are there, too, and contained in those with periods.
  double best_of_plots = -1e9;
  for (const Candidate& candidate : result.random) {
    const bool is_of_plots = candidate.fit.specification.random.size() == 1;
    if (is_of_plots && candidate.rank > 0) {
      best_of_plots = std::max(best_of_plots, candidate.fit.log_likelihood);
    }
    if (candidate.chosen) {
      REQUIRE(candidate.test);
      CHECK(candidate.test->p < 1e-3);
    }
  }
  CHECK(fit.log_likelihood > best_of_plots);
  REQUIRE(result.left_out);
  CHECK(result.left_out->folds == kPlots);
  CHECK(result.left_out->trees == 2 * kPlots * kTrees);
}

TEST_CASE("trees have an effect of their own, which a coefficient between plots does not hide") {
  StudyConfiguration settings = settings_of("year");
  settings.study.covariates = {};
  settings.units.circle = {};
  const StudyRecord record = whole_study(source_of(trees_csv()), test::catalogue(), settings);
  const ResponseStudy& result = record.study.results.front();
  // Without the trees, two coefficients vary between plots, to which no tree's effect could be
  // added inside the range of the parameters.
  CHECK(result.chosen_terms(&ResponseStudy::random) == "a | plot; a | plot:tree");
  REQUIRE(result.nlme);
  const fit::FittedModel& fit = result.nlme->fit;
  // Four standard errors of standard deviations of 192 errors and 88 differences of trees.
  CHECK(fit.sigma == Approx(0.5).margin(4.0 * 0.5 / std::sqrt(2.0 * 192.0)));
  CHECK(fit.random.back().sd()[0] == Approx(1.5).margin(4.0 * 1.5 / std::sqrt(2.0 * 88.0)));
}

TEST_CASE("tables and predictions show both groupings") {
  const StudyRecord& record = repeated_study();
  const std::vector<FormattedTable> tables = study_tables(record, test::catalogue());
  const std::string components = to_csv(table_named(tables, "variance_components"));
  CHECK_THAT(components, Contains("sd(a | plot)"));
  CHECK_THAT(components, Contains("| campaign)"));
  const FormattedTable& effects = table_named(tables, "plot_effects");
  CHECK(effects.columns[3].name == "campaign");
  const fit::FittedModel& fit = record.study.results.front().nlme->fit;
  CHECK(effects.rows.size() ==
        kPlots * fit.random.front().names.size() + 2 * kPlots * fit.random.back().names.size());
  // Rows of each time have the random effects of that time, as the fit has them.
  const data::Table predicted = predictions_of(record, library_of(record));
  const ResponseStudy& result = record.study.results.front();
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    CHECK(predicted.numbers("h_conditional")[result.rows[i]] ==
          Approx(result.nlme->fitted_conditional[static_cast<Eigen::Index>(i)]).epsilon(1e-12));
  }
}

TEST_CASE("what cannot be a period is refused") {
  const auto run = [](const StudyConfiguration& settings) {
    whole_study(source_of(repeated_csv()), test::catalogue(), settings);
  };
  CHECK_THROWS_WITH(run(settings_of("plot")), Contains("another column than the groups"));
  CHECK_THROWS_WITH(run(settings_of("date")), Contains("unknown column 'date'"));
  StudyConfiguration stand = settings_of("campaign");
  stand.units.per = stand::SearchScope::kStand;
  CHECK_THROWS_WITH(run(stand), Contains("`per=plot`"));
  StudyConfiguration number = settings_of("campaign");
  number.study.candidates["h"] = {"h ~ a + b*dbh + c*campaign"};
  CHECK_THROWS_WITH(run(number), Contains("use 'campaign' as a number"));
}
