// SPDX-License-Identifier: MIT
// Correct digits of least-squares fits on the 27 nonlinear problems of NIST's Statistical Reference
// Datasets, from both certified starts and from none.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "nist.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/least_squares.hpp"

using namespace silvafit;
using test::NistProblem;

namespace {

/// NIST certifies 11 digits.
constexpr double kCertifiedDigits = 11.0;

/// Minus the logarithm of the relative error, between 0 and the certified digits.
double digits(double value, double certified) {
  if (!std::isfinite(value)) return 0.0;
  const double error = std::abs(value - certified) / std::abs(certified);
  return std::clamp(error > 0.0 ? -std::log10(error) : kCertifiedDigits, 0.0, kCertifiedDigits);
}

/// The worst coefficient's digits.
struct Score {
  double estimates = kCertifiedDigits;
  double errors = kCertifiedDigits;
  double sum_of_squares = 0.0;
  bool converged = false;
};

Score score(const NistProblem& problem, const std::vector<double>* start) {
  const fit::NonlinearModel model(fit::specify_model(problem.formula, {}, problem.table),
                                  problem.table);
  fit::LeastSquaresOptions options;
  const std::size_t count = problem.certified.size();
  for (std::size_t j = 0; start != nullptr && j < count; ++j) {
    options.start["b" + std::to_string(j + 1)] = (*start)[j];
  }
  const fit::LeastSquaresFit fit = fit_least_squares(model, options);
  Score result;
  result.converged = fit.convergence.converged();
  result.sum_of_squares = digits(fit.sum_of_squares, problem.sum_of_squares);
  const Eigen::VectorXd errors = fit.standard_errors();
  for (std::size_t j = 0; j < count; ++j) {
    const Eigen::Index i = model.coefficient_index("b" + std::to_string(j + 1));
    result.estimates = std::min(result.estimates, digits(fit.estimate[i], problem.certified[j]));
    result.errors = std::min(result.errors, digits(errors[i], problem.standard_deviations[j]));
  }
  return result;
}

std::string mark(const Score& one) { return one.converged ? "" : " (not converged)"; }

std::string from_start(const Score& one) {
  return fmt::format("{:.1f} | {:.1f}{}", one.estimates, one.errors, mark(one));
}

/// Without a start, sums of exponentials may come with their terms in another order, so that only
/// the minimum itself can be compared.
std::string from_none(const Score& one) {
  return fmt::format("{:.1f}{}", one.sum_of_squares, mark(one));
}

void run() {
  fmt::print(
      "| problem | start 1: estimates | errors | start 2: estimates | errors | no start: sum of "
      "squares |\n"
      "|---|---|---|---|---|---|\n");
  for (const std::string& name : test::nist_names()) {
    const NistProblem problem = test::read_nist(name);
    fmt::print("| {} | {} | {} | {} |\n",
               name,
               from_start(score(problem, &problem.starts[0])),
               from_start(score(problem, &problem.starts[1])),
               from_none(score(problem, nullptr)));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Prints correct digits (minus log10 of the relative error, the worst coefficient's, at most "
      "the 11 that are certified)."};
  CLI11_PARSE(app, argc, argv);
  return silvafit::bench::exit_status([&] { run(); });
}
