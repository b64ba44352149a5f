// SPDX-License-Identifier: MIT
#include "least_squares/jacobian_factors.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "silvafit/base/random.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;

namespace {

/// Columns of very different lengths, and a response.
struct Regression {
  MatrixXd jacobian{};
  VectorXd residuals{};
};

Regression regression(Index rows) {
  silvafit::Random random(7);
  Regression result{.jacobian = MatrixXd(rows, 3), .residuals = VectorXd(rows)};
  for (Index i = 0; i < rows; ++i) {
    result.jacobian.row(i) << 1.0, 1e6 * random.normal(), 1e-4 * random.normal();
    result.residuals[i] = random.normal();
  }
  return result;
}

}  // namespace

TEST_CASE("triangles of blocks of rows give the least-squares solution and its covariance") {
  // Fewer rows than columns, less than a block, exactly one, and several with a rest.
  const Index rows = GENERATE(2, 40, 512, 1300);
  INFO(rows << " rows");
  const Regression data = regression(rows);
  const JacobianFactors factors(data.jacobian, JacobianFactors::kRankTolerance, data.residuals);
  REQUIRE(factors.rank() == std::min<Index>(rows, 3));
  const VectorXd step = factors.to_coefficients(factors.projected());
  // The fitted values do not depend on the choice of a solution if there are several.
  const VectorXd expected =
      data.jacobian * data.jacobian.colPivHouseholderQr().solve(data.residuals);
  CHECK((data.jacobian * step - expected).norm() < 1e-11 * data.residuals.norm());
  if (rows < 3) return;
  CHECK(factors.confounded().empty());
  const MatrixXd root = factors.to_coefficients(MatrixXd::Identity(3, 3));
  // Columns of equal length, so that the inverse of J'J loses no digits.
  const VectorXd length = data.jacobian.colwise().norm();
  const MatrixXd unit = data.jacobian * length.cwiseInverse().asDiagonal();
  const MatrixXd scaled = length.asDiagonal() * (root * root.transpose()) * length.asDiagonal();
  CHECK(scaled.isApprox((unit.transpose() * unit).inverse(), 1e-11));
}

TEST_CASE("columns that are linearly dependent are found over several blocks of rows") {
  Regression data = regression(1300);
  data.jacobian.col(1) = 3.0 * data.jacobian.col(0);
  const JacobianFactors factors(data.jacobian);
  CHECK(factors.rank() == 2);
  CHECK(factors.confounded() == std::vector<Index>{0, 1});
}

TEST_CASE("a Jacobian without columns has rank 0") {
  const JacobianFactors factors(MatrixXd(5, 0), JacobianFactors::kRankTolerance, VectorXd::Ones(5));
  CHECK(factors.rank() == 0);
  CHECK(factors.projected().size() == 0);
  CHECK(factors.confounded().empty());
  CHECK(factors.to_coefficients(MatrixXd(0, 2)).rows() == 0);
}
