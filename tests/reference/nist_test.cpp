// SPDX-License-Identifier: MIT
// Certified to 11 digits (StRD, National Institute of Standards and Technology).
#include "nist.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/fit/least_squares.hpp"

using namespace silvafit;
using test::NistProblem;

namespace {

/// Correct digits of a value, up to the 11 that are certified.
double digits(double value, double certified) {
  return std::min(11.0, -std::log10(std::abs(value / certified - 1.0)));
}

fit::NonlinearModel model_of_problem(const NistProblem& problem) {
  return {fit::specify_model(problem.formula, {}, problem.table), problem.table};
}

std::string coefficient(std::size_t j) { return "b" + std::to_string(j + 1); }

fit::LeastSquaresFit from_start(const NistProblem& problem, const std::vector<double>& start) {
  fit::LeastSquaresOptions options;
  for (std::size_t j = 0; j < start.size(); ++j) options.start[coefficient(j)] = start[j];
  return fit_least_squares(model_of_problem(problem), options);
}

void check_certified(const NistProblem& problem, const fit::LeastSquaresFit& fit) {
  INFO(problem.name << ": " << fit.convergence.verdict());
  CHECK(fit.convergence.converged());
  const fit::NonlinearModel model = model_of_problem(problem);
  // Lanczos1 is exact to 13 digits of the data: its residuals are at the rounding of doubles.
  const double deviation_digits = problem.name == "Lanczos1" ? 3.0 : 10.0;
  for (std::size_t j = 0; j < problem.certified.size(); ++j) {
    const Eigen::Index i = model.coefficient_index(coefficient(j));
    INFO(coefficient(j));
    CHECK(digits(fit.estimate[i], problem.certified[j]) > 10.0);
    CHECK(digits(fit.standard_errors()[i], problem.standard_deviations[j]) > deviation_digits);
  }
}

}  // namespace

TEST_CASE("the 27 problems of NIST are solved from both starts to ten digits", "[reference]") {
  for (const std::string& name : test::nist_names()) {
    const NistProblem problem = test::read_nist(name);
    for (const std::vector<double>& start : problem.starts) {
      check_certified(problem, from_start(problem, start));
    }
  }
}

TEST_CASE("23 of the 27 problems of NIST need no start", "[reference]") {
  for (const std::string& name : test::nist_names()) {
    // Two peaks or two unknown cycles: without a start, these lead to other minima.
    if (name == "Gauss1" || name == "Gauss2" || name == "Gauss3" || name == "ENSO") continue;
    const NistProblem problem = test::read_nist(name);
    const fit::LeastSquaresFit fit = fit_least_squares(model_of_problem(problem));
    INFO(name << ": " << fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    // By the sum of squares, because sums of exponentials may be in another order.
    CHECK(digits(fit.sum_of_squares, problem.sum_of_squares) > (name == "Lanczos1" ? 2.0 : 9.0));
  }
}
