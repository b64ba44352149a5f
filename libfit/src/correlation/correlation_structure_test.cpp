// SPDX-License-Identifier: MIT
#include "correlation/correlation_structure.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "silvafit/base/error.hpp"

using namespace silvafit;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using fit::CorrelationStructure;

namespace {

/// Five rows at uneven places on a line.
const MatrixXd kLine = (MatrixXd(5, 1) << 0, 1, 2, 4, 7).finished();
const MatrixXd kPlane = (MatrixXd(4, 2) << 0, 0, 3, 1, 1, 5, 6, 2).finished();

CorrelationStructure structure(const std::string& text) {
  return {fit::parse_correlation(text),
          {.unit = 1.3, .farthest = 8.0, .largest = 5, .times = {0, 1, 2, 4, 7}}};
}

/// Parameters inside the range of a structure.
VectorXd parameters_of(const CorrelationStructure& of) {
  return VectorXd::LinSpaced(of.parameter_count(), 0.9, -0.6);
}

MatrixXd places_of(const CorrelationStructure& of) {
  MatrixXd places = of.correlation().columns.size() == 2 ? kPlane : kLine;
  for (double& place : places.reshaped()) place = of.place(place);
  return places;
}

std::unique_ptr<fit::CorrelationFactor> factor_of(const CorrelationStructure& of,
                                                  const VectorXd& parameters) {
  return of.factor(places_of(of), *of.at(parameters));
}

MatrixXd matrix_of(const fit::CorrelationFactor& factor, Index n) {
  MatrixXd lower = MatrixXd::Identity(n, n);
  factor.color(lower);
  return lower * lower.transpose();
}

const std::vector<std::string> kAll{"ar1(t)",
                                    "car1(t)",
                                    "arma(1, 1, t)",
                                    "arma(2, 0, t)",
                                    "arma(0, 2, t)",
                                    "arma(2, 2, t)",
                                    "compound-symmetry",
                                    "symmetric(t)",
                                    "exponential(t)",
                                    "exponential(x, y)",
                                    "exponential(x, y; nugget)",
                                    "gaussian(x, y; nugget)",
                                    "spherical(x, y; nugget)",
                                    "rational-quadratic(x, y)",
                                    "linear(t; nugget)"};

}  // namespace

TEST_CASE("Correlations are those of their definitions") {
  const auto entry = [](const std::string& text, const VectorXd& natural, Index i, Index j) {
    const CorrelationStructure of = structure(text);
    return matrix_of(*factor_of(of, of.unconstrained(natural)), places_of(of).rows())(i, j);
  };
  // Rows 0 and 3 are 4 apart on the line, rows 0 and 1 of the plane sqrt(10).
  const double d = std::sqrt(10.0);
  const VectorXd range = VectorXd::Constant(1, 5.0);
  const VectorXd nugget = (VectorXd(2) << 5.0, 0.2).finished();
  CHECK(entry("ar1(t)", VectorXd::Constant(1, -0.6), 0, 3) == Approx(std::pow(-0.6, 4)));
  CHECK(entry("car1(t)", VectorXd::Constant(1, 0.8), 0, 3) == Approx(std::pow(0.8, 4)));
  CHECK(entry("compound-symmetry", VectorXd::Constant(1, -0.1), 1, 4) == Approx(-0.1));
  CHECK(entry("exponential(x, y)", range, 0, 1) == Approx(std::exp(-d / 5)));
  CHECK(entry("exponential(x, y; nugget)", nugget, 0, 1) == Approx(0.8 * std::exp(-d / 5)));
  CHECK(entry("gaussian(x, y)", range, 0, 1) == Approx(std::exp(-10.0 / 25)));
  CHECK(entry("spherical(x, y)", range, 0, 1) ==
        Approx(1 - 1.5 * d / 5 + 0.5 * std::pow(d / 5, 3)));
  CHECK(entry("rational-quadratic(x, y)", range, 0, 1) == Approx(1 / (1 + 10.0 / 25)));
  CHECK(entry("linear(t)", range, 0, 3) == Approx(1 - 4.0 / 5));
  // ARMA(1, 1): Box, Jenkins and Reinsel 2008, equation 3.4.7; AR(2): 3.2.27.
  const double phi = 0.7;
  const double theta = 0.4;
  const double first = (1 + phi * theta) * (phi + theta) / (1 + 2 * phi * theta + theta * theta);
  const VectorXd both = (VectorXd(2) << phi, theta).finished();
  CHECK(entry("arma(1, 1, t)", both, 0, 1) == Approx(first));
  CHECK(entry("arma(1, 1, t)", both, 0, 3) == Approx(first * std::pow(phi, 3)));
  const VectorXd second = (VectorXd(2) << 0.5, 0.3).finished();
  CHECK(entry("arma(2, 0, t)", second, 0, 2) == Approx(0.5 * 0.5 / 0.7 + 0.3));
  CHECK(entry("arma(0, 1, t)", VectorXd::Constant(1, 0.5), 0, 1) == Approx(0.5 / 1.25));
  CHECK(entry("arma(0, 1, t)", VectorXd::Constant(1, 0.5), 0, 2) == Approx(0.0).margin(1e-15));
  const CorrelationStructure all = structure("symmetric(t)");
  const VectorXd free = parameters_of(all);
  CHECK(matrix_of(*factor_of(all, free), 5)(1, 3) == Approx(all.natural(free)[5]));
}

TEST_CASE("Factors, their determinants and derivatives agree with the matrix") {
  for (const std::string& text : kAll) {
    INFO(text);
    const CorrelationStructure of = structure(text);
    const VectorXd parameters = parameters_of(of);
    CHECK((of.unconstrained(of.natural(parameters)) - parameters).norm() < 1e-10);
    const auto factor = factor_of(of, parameters);
    REQUIRE(factor);
    const Index n = places_of(of).rows();
    const MatrixXd matrix = matrix_of(*factor, n);
    CHECK(factor->log_determinant() == Approx(0.5 * std::log(matrix.determinant())));
    const MatrixXd x = (MatrixXd(5, 2) << 1, 4, -2, 0.5, 3, 1, 1, -1, 2, 2).finished().topRows(n);
    MatrixXd white = x;
    factor->whiten(white);
    CHECK((white.transpose() * white - x.transpose() * matrix.inverse() * x).norm() < 1e-10);
    for (Index k = 0; k < parameters.size(); ++k) {
      // Central differences have an error of the order of the square of the step.
      constexpr double kStep = 1e-5;
      const auto moved = [&](double step) {
        return factor_of(of, parameters + step * VectorXd::Unit(parameters.size(), k));
      };
      const auto above = moved(kStep);
      const auto below = moved(-kStep);
      CHECK(
          factor->log_slopes()[k] ==
          Approx((above->log_determinant() - below->log_determinant()) / (2 * kStep)).margin(1e-8));
      const auto squares = [&](const fit::CorrelationFactor& at) -> MatrixXd {
        MatrixXd columns = x;
        at.whiten(columns);
        return columns.transpose() * columns;
      };
      const MatrixXd half = white.transpose() * factor->slope(k, white);
      const MatrixXd expected = (squares(*above) - squares(*below)) / (2 * kStep);
      CHECK((half + half.transpose() - expected).norm() < 1e-7 * (1 + expected.norm()));
    }
  }
}

TEST_CASE("Texts of correlations are read and written alike") {
  for (const std::string& text : kAll) CHECK(fit::parse_correlation(text).text() == text);
  for (const std::string text : {"ar1", "ar1(1 | plot)", "arma(1, 0, 1 | plot)", "symmetric"}) {
    CHECK(fit::parse_correlation(text).text() == text);
  }
  // Backquotes are around the name, which keeps them where a sign would separate it.
  CHECK(fit::parse_correlation("car1(`age yr` | `plot no`)").text() == "car1(age yr | plot no)");
  CHECK(fit::parse_correlation("car1(age | `plot/no`)").text() == "car1(age | `plot/no`)");
  CHECK(fit::parse_correlation("car1(age | `plot/no`)").group == "plot/no");
  CHECK(fit::parse_correlation(" exponential( x , y|plot ;nugget ) ").text() ==
        "exponential(x, y | plot; nugget)");
  CHECK(fit::parse_correlation("exponential(x, y; nugget | plot)").text() ==
        "exponential(x, y | plot; nugget)");
  for (const std::string text : {"ar2",
                                 "ar1(x, y)",
                                 "car1",
                                 "arma",
                                 "arma(1)",
                                 "arma(0, 0)",
                                 "arma(1, x)",
                                 "exponential",
                                 "exponential(x; range)",
                                 "ar1(x; nugget)",
                                 "exponential(x; nugget | plot; nugget)",
                                 "compound-symmetry(x)",
                                 "ar1(x",
                                 "ar1(x |)",
                                 "ar1(x | a | b)"}) {
    INFO(text);
    CHECK_THROWS_AS(fit::parse_correlation(text), FormulaError);
  }
}

TEST_CASE("Singular correlations have no factor") {
  const CorrelationStructure of = structure("exponential(x, y)");
  const MatrixXd twice = kPlane(std::vector<Index>{0, 1, 1}, Eigen::all);
  CHECK(of.factor(twice, *of.at(VectorXd::Zero(1))) == nullptr);
  const CorrelationStructure line = structure("car1(t)");
  const MatrixXd same = kLine(std::vector<Index>{0, 1, 1}, Eigen::all);
  CHECK(line.factor(same, *line.at(VectorXd::Zero(1))) == nullptr);
}
