// SPDX-License-Identifier: MIT
#include "simulation/covariance_root.hpp"

#include <catch2/catch.hpp>

using namespace silvafit;

TEST_CASE("covariance roots exist for singular matrices, not for indefinite ones") {
  Eigen::MatrixXd singular(3, 3);
  singular << 4, 2, 0, 2, 1, 0, 0, 0, 0;
  const auto root = study::covariance_root(singular);
  REQUIRE(root.has_value());
  CHECK((*root * root->transpose() - singular).cwiseAbs().maxCoeff() < 1e-15);
  Eigen::MatrixXd indefinite(2, 2);
  indefinite << 1, 1.01, 1.01, 1;
  CHECK_FALSE(study::covariance_root(indefinite).has_value());
  Eigen::MatrixXd covariance_without_variance(2, 2);
  covariance_without_variance << 0, 0.1, 0.1, 1;
  CHECK_FALSE(study::covariance_root(covariance_without_variance).has_value());
}
