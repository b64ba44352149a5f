// SPDX-License-Identifier: MIT
#include "conditional_modes/sparse_factor.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace silvafit::fit;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Cells of two groupings that are crossed, and of a third one within the first, with random
/// places: sparse columns, and a dense end.
Eigen::MatrixXi random_cells(int first, int second, int third, int cells, std::mt19937& random) {
  Eigen::MatrixXi result(3, cells);
  for (int k = 0; k < cells; ++k) {
    const int group = static_cast<int>(random() % static_cast<unsigned>(first));
    result(0, k) = group;
    result(1, k) = first + static_cast<int>(random() % static_cast<unsigned>(second));
    result(2, k) =
        first + second + third * group + static_cast<int>(random() % static_cast<unsigned>(third));
  }
  return result;
}

}  // namespace

TEST_CASE("the sparse factor is that of the dense matrix") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const auto& [first, second, third, cells] :
       {std::tuple{40, 12, 3, 300}, std::tuple{5, 4, 1, 12}, std::tuple{60, 1, 2, 90}}) {
    const Index size = first + second + first * third;
    const Eigen::MatrixXi places = random_cells(first, second, third, cells, random);
    const SparsePattern pattern(size, places);
    MatrixXd dense = 1.5 * MatrixXd::Identity(size, size);
    SparseFactor factor;
    factor.begin(pattern, 1.5);
    for (Index k = 0; k < cells; ++k) {
      const VectorXd root = VectorXd::NullaryExpr(3, [&] { return normal(random); });
      const MatrixXd block = root * root.transpose();
      factor.add(k, block);
      for (Index a = 0; a < 3; ++a) {
        for (Index b = 0; b < 3; ++b) dense(places(a, k), places(b, k)) += block(a, b);
      }
    }
    REQUIRE(factor.factorize());
    const Eigen::LLT<MatrixXd> expected(dense);
    const MatrixXd lower = expected.matrixL();
    const double determinant = 2.0 * lower.diagonal().array().log().sum();
    // Rounding of some hundred operations.
    CHECK(factor.log_determinant() == Approx(determinant).epsilon(1e-12));
    const VectorXd right = VectorXd::NullaryExpr(size, [&] { return normal(random); });
    VectorXd solved = right;
    factor.solve(solved);
    CHECK((solved - expected.solve(right)).cwiseAbs().maxCoeff() < 1e-12);
    factor.invert();
    const MatrixXd inverse = expected.solve(MatrixXd::Identity(size, size));
    double largest = 0.0;
    for (Index k = 0; k < cells; ++k) {
      const SmallMatrix block = factor.inverse_block(k);
      for (Index a = 0; a < 3; ++a) {
        for (Index b = 0; b < 3; ++b) {
          const double error = block(a, b) - inverse(places(a, k), places(b, k));
          largest = std::max(largest, std::abs(error));
        }
      }
    }
    CHECK(largest < 1e-12);
  }
}

TEST_CASE("a matrix that is not positive definite has no sparse factor") {
  Eigen::MatrixXi places(1, 2);
  places << 0, 1;
  const SparsePattern pattern(2, places);
  SparseFactor factor;
  factor.begin(pattern, 1.0);
  factor.add(1, SmallMatrix::Constant(1, 1, -2.0));
  CHECK_FALSE(factor.factorize());
}
