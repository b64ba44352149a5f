// SPDX-License-Identifier: MIT
#include "silvafit/fit/fit_statistics.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace silvafit::fit;

TEST_CASE("statistics by hand") {
  const Eigen::Vector4d observed(1.0, 2.0, 3.0, 6.0);
  const Eigen::Vector4d predicted(1.5, 1.5, 3.0, 5.0);
  // Errors -0.5, 0.5, 0, 1: mean 0.25, squares 1.5, about the mean 1.25; total 14 about mean 3.
  const FitStatistics statistics = fit_statistics(observed, predicted);
  CHECK(statistics.mean_error == 0.25);
  CHECK(statistics.r2 == Approx(1.0 - 1.5 / 14.0).epsilon(1e-15));
  CHECK(statistics.rmse == Approx(std::sqrt(0.0625 + 1.25 / 3.0)).epsilon(1e-15));
  CHECK(statistics.mae == 0.5);
}

TEST_CASE("equal observations have no R2") {
  const FitStatistics statistics =
      fit_statistics(Eigen::Vector3d(5.0, 5.0, 5.0), Eigen::Vector3d(5.0, 5.0, 6.0));
  CHECK(std::isnan(statistics.r2));
  CHECK(statistics.mae == Approx(1.0 / 3.0).epsilon(1e-15));
}

TEST_CASE("the log-likelihoods follow from the paper's RMSE") {
  // Wang et al. 2023, equations 5, 8 and 11. Their E is near zero, so that RMSE^2 = SSE / (n - 1).
  // RMSE has five digits: its rounding moves the log-likelihood by up to 0.02.
  struct Published {
    int n;
    double rmse;
    double log_likelihood;
  };
  for (const Published& row : {Published{961, 2.7644, -2340.27},
                               Published{903, 2.1741, -1982.07},
                               Published{986, 2.4594, -2285.91}}) {
    const double sum_of_squares = row.rmse * row.rmse * (row.n - 1);
    CHECK(least_squares_log_likelihood(sum_of_squares, row.n) ==
          Approx(row.log_likelihood).margin(0.03));
  }
}

TEST_CASE("information criteria count parameters") {
  CHECK(aic(-100.0, 3) == 206.0);
  CHECK(bic(-100.0, 3, 50) == Approx(200.0 + 3.0 * std::log(50.0)));
  CHECK(aicc(-100.0, 3, 50) == Approx(206.0 + 24.0 / 46.0));
  CHECK(std::isinf(aicc(-100.0, 3, 4)));
}
