// SPDX-License-Identifier: MIT
// Whole studies of small simulated stands.
#include "silvafit/study/study.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>

#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;
using Catch::Matchers::Contains;

namespace {

Study study_of(const data::Table& table, StudyOptions options = {}) {
  options.responses = {"h"};
  return run_study(table, test::catalogue(), options);
}

std::vector<double> likelihoods(const std::vector<Candidate>& candidates) {
  std::vector<double> values;
  for (const Candidate& candidate : candidates) {
    // NaN is not equal to itself.
    const double value = candidate.fit.log_likelihood;
    values.push_back(std::isnan(value) ? 0.0 : value);
  }
  return values;
}

bool any_contains(const std::vector<std::string>& texts, const std::string& part) {
  return std::ranges::any_of(
      texts, [&](const std::string& text) { return text.find(part) != std::string::npos; });
}

}  // namespace

TEST_CASE("a study tries every model of each level and finds the covariate with an effect") {
  const Study study = study_of(test::stand({}));
  REQUIRE(study.results.size() == 1);
  const ResponseStudy& result = study.results.front();
  CHECK(result.rows.size() == 240);
  CHECK(result.plots == 8);
  CHECK(result.base.size() == 16);
  REQUIRE(result.ols);
  const auto parameters = static_cast<std::size_t>(result.ols->fit.estimate.size());
  // W, M, C, U on each parameter, the base itself, and one without intercept.
  CHECK(result.covariates.size() == parameters * 15 + 1 + 1);
  REQUIRE(result.with_covariates);
  const std::vector<std::string> names = result.with_covariates->fit.coefficient_names;
  CHECK(std::ranges::any_of(names, [](const std::string& name) { return name.ends_with(":C"); }));
  CHECK(result.variance.size() == 4);
  CHECK(result.converged());
  std::size_t rows =
      result.base.size() + result.covariates.size() + result.random.size() + result.variance.size();
  // Three levels; each of the eight plots is left out once. The chosen random effects with a
  // constant variance are a row of two levels, and one fit.
  CHECK(study.fit_count() == rows - 1 + 3 * 8);
}

TEST_CASE("mixed models are never less likely than the least-squares models they contain") {
  const Study study = study_of(test::stand({}));
  const ResponseStudy& result = study.results.front();
  const double below = result.with_covariates->fit.log_likelihood;
  for (const Candidate& candidate : result.random) {
    INFO(fmt::format("{}", fmt::join(candidate.terms, " + ")));
    if (candidate.rank > 0) CHECK(candidate.fit.log_likelihood >= below - 1e-6);
  }
  const double none = result.variance.front().fit.log_likelihood;
  for (const Candidate& candidate : result.variance) {
    if (candidate.rank > 0) CHECK(candidate.fit.log_likelihood >= none - 1e-6);
  }
  // Larger least-squares models contain level 1.
  for (const Candidate& candidate : result.covariates) {
    if (candidate.rank > 0 && candidate.test) {
      CHECK(candidate.fit.log_likelihood >= result.ols->fit.log_likelihood - 1e-6);
    }
  }
}

TEST_CASE("a study gives the same doubles with any number of threads") {
  const data::Table table = test::stand({});
  const Study one = study_of(table, {.threads = 1});
  for (const unsigned threads : {2U, 5U}) {
    const Study other = study_of(table, {.threads = threads});
    const ResponseStudy& a = one.results.front();
    const ResponseStudy& b = other.results.front();
    CHECK(likelihoods(a.base) == likelihoods(b.base));
    CHECK(likelihoods(a.covariates) == likelihoods(b.covariates));
    CHECK(likelihoods(a.random) == likelihoods(b.random));
    CHECK(likelihoods(a.variance) == likelihoods(b.variance));
    CHECK(a.nlme->fit.estimate == b.nlme->fit.estimate);
    CHECK(a.nlme->fit.random.back().effects == b.nlme->fit.random.back().effects);
  }
}

TEST_CASE("level 2 is skipped with a note if there are no indices") {
  const Study study = study_of(test::stand({.has_indices = false}));
  CHECK(any_contains(study.notes, "no tree positions"));
  const ResponseStudy& result = study.results.front();
  CHECK(result.covariates.empty());
  CHECK(result.with_covariates->fit.log_likelihood == result.ols->fit.log_likelihood);
  CHECK(result.nlme);
}

TEST_CASE("a constant index is not used as a covariate") {
  data::Table table = test::stand({});
  table.set("M", std::vector<double>(table.rows(), 0.0));
  const ResponseStudy result = study_of(table).results.front();
  CHECK(any_contains(result.notes, "M is 0 for all of these trees"));
  for (const Candidate& candidate : result.covariates) {
    CHECK_FALSE(any_contains(candidate.terms, "M"));
  }
}

TEST_CASE("one plot has no level 3, with a sentence in the verdict") {
  const ResponseStudy result = study_of(test::stand({.plots = 1, .trees = 150})).results.front();
  CHECK(result.plots == 1);
  CHECK(result.random.empty());
  CHECK(result.variance.empty());
  CHECK_FALSE(result.nlme);
  CHECK(result.converged());
  CHECK_THAT(result.verdict(), Contains("There is only one plot: level 3 was skipped."));
}

TEST_CASE("species with too few trees are noted, with their number") {
  StudyOptions options;
  options.minimum_trees = 241;
  const Study study = study_of(test::stand({}), options);
  CHECK(study.results.empty());
  CHECK(any_contains(study.notes, "fewer than 241): SM h (240)"));
  options.minimum_trees = 240;
  CHECK(study_of(test::stand({}), options).results.size() == 1);
}

TEST_CASE("only core trees with all measures are used") {
  data::Table table = test::stand({});
  std::vector<double> core(table.rows(), 1.0);
  core[7] = 0.0;
  table.set("core", core);
  std::vector<double> heights(table.numbers("h").begin(), table.numbers("h").end());
  heights[9] = data::kMissing;
  table.set("h", heights);
  std::vector<double> angles(table.numbers("W").begin(), table.numbers("W").end());
  angles[11] = data::kMissing;
  table.set("W", angles);
  const ResponseStudy result = study_of(table).results.front();
  CHECK(result.rows.size() == 237);
  for (const std::size_t row : {7U, 9U, 11U}) {
    CHECK(std::ranges::find(result.rows, row) == result.rows.end());
  }
  CHECK(any_contains(result.notes, "1 tree without a structural unit was excluded."));
}

TEST_CASE("fits that fail are listed with a reason, without rank and test") {
  // Heights that do not depend on DBH do not determine the shape of the curve.
  data::Table table = test::stand({.has_indices = false});
  table.set("h", std::vector<double>(table.rows(), 12.0));
  const Study study = study_of(table);
  const ResponseStudy& result = study.results.front();
  CHECK(result.base.size() == 16);
  std::size_t failures = 0;
  for (const Candidate& candidate : result.base) {
    if (candidate.fit.convergence.converged()) continue;
    ++failures;
    CHECK_FALSE(candidate.fit.convergence.verdict().empty());
    CHECK(candidate.rank == 0);
    CHECK_FALSE(candidate.chosen);
  }
  CHECK(failures > 0);
}

TEST_CASE("unknown species and responses are usage errors that list the available ones") {
  StudyOptions options;
  options.species = {"XX"};
  CHECK_THROWS_AS(run_study(test::stand({}), test::catalogue(), options), UsageError);
  CHECK_THROWS_WITH(run_study(test::stand({}), test::catalogue(), options), Contains("SM"));
  options.species.clear();
  options.responses = {"volume"};
  CHECK_THROWS_AS(run_study(test::stand({}), test::catalogue(), options), UsageError);
  CHECK_THROWS_WITH(run_study(test::stand({}), test::catalogue(), options), Contains("cw, h, hcb"));
  // A response of the catalogue that the inventory lacks gives only a note.
  options.responses = {"h", "cw"};
  const Study study = run_study(test::stand({}), test::catalogue(), options);
  CHECK(study.results.size() == 1);
  CHECK(any_contains(study.notes, "no column cw"));
}

TEST_CASE("progress counts every fit of every stage once") {
  std::atomic<std::size_t> calls{0};
  StudyOptions options;
  options.responses = {"h"};
  const Study study = run_study(test::stand({}),
                                test::catalogue(),
                                options,
                                [&](const std::string&, std::size_t done, std::size_t total) {
                                  ++calls;
                                  if (done > total) calls = 0;
                                });
  CHECK(calls == study.fit_count());
}

TEST_CASE("the note on too few core trees has the number of measured trees") {
  data::Table table = test::stand({.plots = 2, .trees = 40});
  std::vector<double> core(table.rows(), 0.0);
  for (std::size_t row = 0; row < 10; ++row) core[row] = 1.0;
  StudyOptions options{.responses = {"h"}};
  options.minimum_trees = 20;
  table.set("core", core);
  const std::vector<std::string> notes = run_study(table, test::catalogue(), options).notes;
  CHECK_THAT(notes,
             Catch::Matchers::VectorContains(std::string(
                 "Too few trees for models (fewer than 20): SM h (10 core trees of 80 measured). "
                 "Trees near the plot edge are not core trees and are not counted; edge "
                 "correction none counts them.")));

  // If all trees are core trees, there is one number.
  options.minimum_trees = 100;
  table.set("core", std::vector<double>(table.rows(), 1.0));
  CHECK_THAT(run_study(table, test::catalogue(), options).notes,
             Catch::Matchers::VectorContains(
                 std::string("Too few trees for models (fewer than 100): SM h (80).")));
}

TEST_CASE(
    "candidates are compared on a sample of many trees, and chosen models are fitted to all") {
  const data::Table table = test::stand({.plots = 12, .trees = 60, .has_indices = false});
  StudyOptions options;
  options.compared_trees = 480;
  const Study study = study_of(table, options);
  const ResponseStudy& result = study.results.front();
  CHECK(any_contains(result.notes, "a representative sample of 480 of the 720 trees"));
  CHECK(result.base.front().fit.observations == 480);
  CHECK(result.random.front().fit.observations == 480);
  REQUIRE(result.nlme);
  CHECK(result.ols->fit.observations == 720);
  CHECK(result.nlme->fit.observations == 720);
  CHECK(result.nlme->fit.convergence.converged());
  // The reported fit is the fit to all trees: the same as alone.
  fit::FitModelOptions alone;
  alone.method = fit::Method::kLindstromBates;
  const auto again = fit::fit_model(result.nlme->fit.specification, table, alone);
  CHECK(result.nlme->fit.log_likelihood == Approx(again.fit.log_likelihood).epsilon(1e-8));
  // All trees are used for comparisons on request.
  options.compared_trees = 0;
  CHECK(study_of(table, options).results.front().base.front().fit.observations == 720);
}

TEST_CASE("without plausible curves the best base model is chosen with a doubt") {
  StudyOptions options;
  // Heights have a limit; a parabola through them decreases beyond its vertex.
  options.candidates["h"] = {"h ~ a + b*dbh + c*dbh^2"};
  const ResponseStudy result =
      study_of(test::stand({.has_indices = false}), options).results.front();
  REQUIRE(result.ols);
  CHECK(result.base.front().chosen);
  CHECK_FALSE(result.base.front().objection.empty());
  CHECK_FALSE(result.is_sound());
  REQUIRE_FALSE(result.doubts.empty());
  CHECK_THAT(result.doubts.front(), Contains("No base model has plausible curves"));
}

TEST_CASE("a model that is worse than the mean of the trees is doubtful") {
  data::Table table = test::stand({.has_indices = false});
  Random random(17);
  std::vector<double> heights(table.rows());
  // Independent of all columns.
  for (double& height : heights) height = random.uniform(8.0, 30.0);
  table.set("h", heights);
  const ResponseStudy noise = study_of(table).results.front();
  REQUIRE(noise.ols);
  CHECK_FALSE(noise.is_sound());
  CHECK(any_contains(noise.doubts, "The mean of the trees describes them better"));

  const ResponseStudy curve = study_of(test::stand({.has_indices = false})).results.front();
  CHECK_FALSE(any_contains(curve.doubts, "The mean of the trees"));
}

TEST_CASE("a model whose residual variance is that of a few trees is doubtful and names them") {
  data::Table table = test::stand({});
  const std::vector<double> measured(table.numbers("h").begin(), table.numbers("h").end());
  constexpr std::size_t kTree = 40;  // plot 02, tree 11
  std::vector<double> heights = measured;
  for (const std::size_t row : {kTree, std::size_t{100}}) heights[row] *= 10.0;
  table.set("h", heights);
  const ResponseStudy wrong = study_of(table).results.front();
  CHECK_FALSE(wrong.is_sound());
  CHECK(any_contains(wrong.doubts, "2 of 240 trees make up"));
  CHECK(any_contains(wrong.doubts, "tree 11 of plot 02"));

  // About 10 residual standard deviations, a third of the residual variance. A variance function
  // could describe a single tree.
  StudyOptions constant;
  constant.variance_functions.clear();
  heights = measured;
  heights[kTree] += 8.0;
  table.set("h", heights);
  const ResponseStudy odd = study_of(table, constant).results.front();
  CHECK(odd.is_sound());
  CHECK(any_contains(odd.notes, "Outlying tree: tree 11 of plot 02"));

  const ResponseStudy right = study_of(test::stand({})).results.front();
  CHECK_FALSE(any_contains(right.notes, "Outlying tree"));
}

TEST_CASE("a note names residuals that neighbors share") {
  data::Table table = test::stand({});
  const std::vector<double> measured(table.numbers("h").begin(), table.numbers("h").end());
  std::vector<double> x, y, heights;
  for (std::size_t row = 0; row < measured.size(); ++row) {
    // Pairs of trees a meter apart, which share an error of about a meter.
    const std::size_t pair = row / 2;
    x.push_back(10.0 * static_cast<double>(pair % 15) + static_cast<double>(row % 2));
    y.push_back(0.0);
    heights.push_back(measured[row] + 1.5 * std::sin(100.0 * static_cast<double>(pair * pair)));
  }
  table.set("x", x);
  table.set("y", y);
  const std::string note = "nearest neighbors are correlated";
  CHECK_FALSE(any_contains(study_of(table).results.front().notes, note));
  table.set("h", heights);
  CHECK(any_contains(study_of(table).results.front().notes, note));
}
