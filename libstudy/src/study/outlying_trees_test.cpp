// SPDX-License-Identifier: MIT
#include <boost/math/distributions/normal.hpp>
#include <catch2/catch.hpp>
#include <cmath>

#include "study/outliers.hpp"

using namespace silvafit::study;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The quantiles of a normal distribution, so that the robust standard deviation is that of the
/// distribution and no residual is an outlier.
VectorXd normal_residuals(Index count, double sd) {
  VectorXd result(count);
  for (Index i = 0; i < count; ++i) {
    const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    result[i] = sd * boost::math::quantile(boost::math::normal(), p);
  }
  return result;
}

}  // namespace

TEST_CASE("normal residuals have no outlying trees") {
  const OutlyingTrees found = outlying_trees(normal_residuals(20000, 0.3));
  CHECK(found.observations.empty());
  CHECK(found.share == 0.0);
}

TEST_CASE("outlying trees are found although they inflate the residual variance") {
  constexpr Index kTrees = 1001;
  constexpr double kSd = 0.1;
  VectorXd residuals = normal_residuals(kTrees, kSd);
  // A tenth of the residuals is far away, so that their standard deviation is about 16.
  double sum = 0.0;
  for (Index i = 0; i < kTrees; i += 10) {
    residuals[i] = i % 20 == 0 ? 50.0 : -60.0;
    sum += residuals[i] * residuals[i];
  }
  const OutlyingTrees found = outlying_trees(residuals);
  REQUIRE(found.observations.size() == 101);
  CHECK(found.observations.front() == 10);
  CHECK(residuals[found.observations.back()] == 50.0);
  CHECK(found.share == Approx(sum / residuals.squaredNorm()));
  // The other nine tenths reach the median of absolute residuals at the quantile 1 / 1.8.
  const double scale = kSd * boost::math::quantile(boost::math::normal(), 0.5 + 0.5 / 1.8) /
                       boost::math::quantile(boost::math::normal(), 0.75);
  // The quantiles of 900 residuals are exact to their spacing near the median.
  CHECK(found.distances.front() == Approx(60.0 / scale).epsilon(0.01));
}

TEST_CASE("residuals without a scale have no outlying trees") {
  CHECK(outlying_trees(VectorXd()).observations.empty());
  VectorXd mostly_zero = VectorXd::Zero(9);
  mostly_zero[3] = 5.0;
  CHECK(outlying_trees(mostly_zero).observations.empty());
  mostly_zero[3] = std::nan("");
  CHECK(outlying_trees(mostly_zero).observations.empty());
}
