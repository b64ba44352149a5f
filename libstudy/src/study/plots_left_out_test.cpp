// SPDX-License-Identifier: MIT
// Predictions for plots left out: the paired t, and the sentence on a mixed model that is worse.
#include "study/plots_left_out.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;

TEST_CASE("the paired t has plots as replicates") {
  // Squared errors 4, 1 | 9 | 1 against 1, 1 | 1 | 4: sums of differences 3, 8, -3.
  const Eigen::Vector4d first(2.0, -1.0, 3.0, 1.0);
  const Eigen::Vector4d second(1.0, 1.0, -1.0, 2.0);
  // Mean 8/3, variance ((1/3)^2 + (16/3)^2 + (17/3)^2) / 2 = 91/3, t = (8/3) / sqrt(91/9).
  CHECK(paired_t(first, second, {0, 0, 1, 2}) == Approx(8.0 / std::sqrt(91.0)).epsilon(1e-12));
  CHECK(paired_t(second, first, {0, 0, 1, 2}) == Approx(-8.0 / std::sqrt(91.0)).epsilon(1e-12));
  // A plot without trees is not a replicate.
  CHECK(paired_t(first, second, {0, 0, 4, 2}) == Approx(8.0 / std::sqrt(91.0)).epsilon(1e-12));
}

TEST_CASE("equal errors and a single plot have no t") {
  const Eigen::Vector3d errors(1.0, 2.0, 3.0);
  CHECK(paired_t(errors, errors, {0, 1, 2}) == 0.0);
  CHECK(paired_t(errors, 2.0 * errors, {0, 0, 0}) == 0.0);
}

TEST_CASE("only a mixed model that is worse than the better least-squares model is doubtful") {
  LeftOutPlots left_out{.folds = 5,
                        .trees = 100,
                        .rmse_ols = 2.0,
                        .rmse_covariates = 1.5,
                        .rmse_nlme = 1.75,
                        .is_worse = true};
  CHECK(doubt_of(left_out, "m") ==
        "For plots without measured trees the mixed model predicts worse than least squares with "
        "covariates: RMSE 1.750 m against 1.500 m for plots left out (5 folds). Use least squares "
        "for such plots.");
  left_out.is_worse = false;
  CHECK(doubt_of(left_out, "m").empty());
}

TEST_CASE("the levels of a study predict all trees of plots left out") {
  const data::Table table = test::stand({.has_indices = false});
  const Study study = run_study(table, test::catalogue(), {.responses = {"h"}});
  const ResponseStudy& result = study.results.front();
  REQUIRE(result.left_out);
  CHECK(result.left_out->folds == 8);  // as many as there are plots
  CHECK(result.left_out->trees + result.left_out->trees_without == 240);
  // The stand has limits with a standard deviation of 2 m by plot and residuals of 0.7 m, so that
  // trees of an unknown plot are off by about sqrt((2 * 0.8)^2 + 0.7^2) = 1.7 m.
  CHECK(result.left_out->rmse_nlme > 1.0);
  CHECK(result.left_out->rmse_nlme < 2.6);
  CHECK(result.left_out->rmse_ols < 2.6);
  // R2 and RMSE are of the same errors. RMSE^2 is E^2 + (SSE - n E^2)/(n - 1), so that SSE is
  // (n - 1) RMSE^2 + E^2, of which E^2 is at most RMSE^2.
  const LeftOutPlots& left_out = *result.left_out;
  const double ratio = (1.0 - left_out.r2_nlme) / (1.0 - left_out.r2_ols);
  CHECK(ratio == Approx(std::pow(left_out.rmse_nlme / left_out.rmse_ols, 2))
                     .epsilon(1.0 / (static_cast<double>(left_out.trees) - 1.0)));
  CHECK(left_out.r2_ols > 0.5);
  CHECK(left_out.r2_ols < result.ols->fit.population.r2);
}

TEST_CASE("a single plot cannot be left out") {
  const data::Table table = test::stand({.plots = 1, .trees = 150, .has_indices = false});
  const Study study = run_study(table, test::catalogue(), {.responses = {"h"}});
  CHECK_FALSE(study.results.front().left_out);
}
