// SPDX-License-Identifier: MIT
#include "model/symmetric_eigen.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace silvafit::fit;

TEST_CASE("a symmetric matrix is the sum of its eigenvectors' projections") {
  // Eigenvalues 1 and 3 of [2 1; 1 2], by hand; products of four roundings differ by a few 1e-16.
  Eigen::Matrix2d matrix;
  matrix << 2.0, 1.0, 1.0, 2.0;
  const SymmetricEigen of = symmetric_eigen(matrix);
  CHECK(of.values[0] == Approx(1.0).epsilon(1e-15));
  CHECK(of.values[1] == Approx(3.0).epsilon(1e-15));
  CHECK((of.vectors * of.values.asDiagonal() * of.vectors.transpose() - matrix).norm() < 4e-15);
}

TEST_CASE("eigenvalues of a matrix that is not finite are NaN") {
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    matrix(1, 1) = value;
    const SymmetricEigen of = symmetric_eigen(matrix);
    CHECK(of.values.array().isNaN().all());
    CHECK(of.vectors.array().isNaN().all());
  }
}
