// SPDX-License-Identifier: MIT
#include "optimization/curvature_certificate.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using namespace silvafit::fit;

TEST_CASE("the decrement is that of Newton's step, in any units") {
  MatrixXd hessian(2, 2);
  hessian << 4.0, 1.0, 1.0, 2.0;
  const Vector2d gradient(0.3, -0.2);
  // g'H^-1 g with H^-1 = [2 -1; -1 4] / 7.
  const double expected = (2.0 * 0.09 + 2.0 * 0.06 + 4.0 * 0.04) / 7.0;
  CHECK(CurvatureCertificate(hessian, gradient).decrement() == Approx(expected).epsilon(1e-12));
  const Vector2d units(30.0, 0.1);
  const MatrixXd scaled = units.asDiagonal() * hessian * units.asDiagonal();
  const VectorXd slopes = units.cwiseProduct(gradient);
  CHECK(CurvatureCertificate(scaled, slopes).decrement() == Approx(expected).epsilon(1e-9));
  CHECK(CurvatureCertificate(hessian, gradient).downwards().size() == 0);
}

TEST_CASE("a direction without curvature is ignored unless it has a gradient") {
  const MatrixXd hessian = Vector3d(1.0, 2.0, 0.0).asDiagonal();
  CHECK(CurvatureCertificate(hessian, Vector3d(0.0, 0.0, 1e-9)).decrement() == 0.0);
  CHECK(CurvatureCertificate(hessian, Vector3d(0.0, 0.0, 1e-1)).decrement() > 1.0);
}

TEST_CASE("at a saddle point the direction of descent is returned") {
  MatrixXd hessian(2, 2);
  hessian << 1.0, 0.0, 0.0, -4.0;
  const VectorXd way = CurvatureCertificate(hessian, Vector2d::Zero()).downwards();
  REQUIRE(way.size() == 2);
  CHECK(way[0] == Approx(0.0).margin(1e-15));
  CHECK(std::abs(way[1]) == Approx(0.5).epsilon(1e-12));  // one standard deviation
}

TEST_CASE("insignificant negative curvature is not a saddle point") {
  // The two halves of the matrix differ by more than the eigenvalue that is negative.
  MatrixXd hessian(2, 2);
  hessian << 1.0, 0.0, 1e-3, -1e-4;
  hessian(1, 1) = 1.0;
  hessian(0, 1) = 1.0 + 1e-4;
  hessian(1, 0) = 1.0 - 1e-4;
  CHECK(CurvatureCertificate(hessian, Vector2d::Zero()).downwards().size() == 0);
}

TEST_CASE("the inverse omits directions that are not identifiable") {
  const MatrixXd hessian = Vector3d(4.0, 0.0, 0.5).asDiagonal();
  const MatrixXd expected = Vector3d(0.25, 0.0, 2.0).asDiagonal();
  CHECK((informed_inverse(hessian) - expected).norm() < 1e-14);
}

TEST_CASE("a Hessian that is not finite has no inverse") {
  MatrixXd hessian = MatrixXd::Identity(3, 3);
  CHECK(informed_inverse(hessian).isApprox(hessian, 1e-14));
  hessian(1, 2) = std::nan("");
  CHECK(informed_inverse(hessian).array().isNaN().all());
  hessian(1, 2) = std::numeric_limits<double>::infinity();
  CHECK(informed_inverse(hessian).array().isNaN().all());
}
